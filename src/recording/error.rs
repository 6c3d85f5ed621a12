//! Errors of recordings.

use std::io;

use crate::map::MapError;
use crate::navigator::Fault;
use crate::settings::SettingError;

/// Why a recording cannot be written, replayed or read as a log.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecordingError {
    /// The file could not be read or written.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// The system provides no thread for the recorder.
    #[error("no thread for the recorder: {0}")]
    NoThread(io::Error),
    /// The file is no MCAP file.
    #[error(
        "the file is no MCAP file, whatever its name: choose one that `inbye drive --record NAME.mcap` or `ros2 bag` wrote"
    )]
    NotMcap,
    /// The file is no recording of inbye.
    #[error(
        "the file has no {missing}: it is no recording of inbye, or it was truncated before its first tick"
    )]
    NotOurs {
        /// The missing part.
        missing: &'static str,
    },
    /// The recording has the format of another version.
    #[error(
        "the recording has format {found}; this inbye reads format {FORMAT}: replay it with the build of inbye ({writer}) that wrote it"
    )]
    OtherFormat {
        /// Format of the recording.
        found: String,
        /// Version of inbye that wrote it.
        writer: String,
    },
    /// The metadata of the drive is invalid.
    #[error("the recording's {name} is invalid: {reason}")]
    BadMetadata {
        /// Name of the attachment.
        name: &'static str,
        /// The cause.
        reason: String,
    },
    /// The file is damaged.
    #[error("the file is damaged after {ticks} ticks: {reason}; use another copy of the file")]
    Damaged {
        /// Number of ticks before the damage.
        ticks: u64,
        /// The cause.
        reason: String,
    },
    /// The caller ended the replay.
    #[error("the replay was interrupted after {ticks} ticks")]
    Interrupted {
        /// Number of ticks that were replayed.
        ticks: u64,
    },
    /// A log without messages of a type.
    #[error(
        "the file has no {missing}: a log needs sensor_msgs/LaserScan and nav_msgs/Odometry, and /tf_static; record their topics"
    )]
    NoMessages {
        /// The type of the messages.
        missing: &'static str,
    },
    /// A log that ends within its first chunk.
    #[error("the file was cut off before its first message: use another copy of the file")]
    TruncatedLog,
    /// A log with messages of one type on several topics.
    #[error("the file has {name} on {topics}: choose one of these topics")]
    SeveralTopics {
        /// The type of the messages.
        name: &'static str,
        /// The topics.
        topics: String,
    },
    /// No messages of a type on the requested topic.
    #[error("the file has no {name} on {topic}: they are on {topics}")]
    NotOnTopic {
        /// The type of the messages.
        name: &'static str,
        /// The requested topic.
        topic: String,
        /// The topics with such messages.
        topics: String,
    },
    /// The place of the lidar on the robot is not known.
    #[error(
        "the file has no transform from {base} to {lidar}, the place of the lidar on the robot: record /tf_static as well"
    )]
    NoMount {
        /// Frame of the scans.
        lidar: String,
        /// Frame of the robot.
        base: String,
    },
    /// The lidar is not upright on the robot.
    #[error(
        "the frame {lidar} is tilted against {base}: the lidar must be upright, and level within 10 degrees"
    )]
    TiltedMount {
        /// Frame of the scans.
        lidar: String,
        /// Frame of the robot.
        base: String,
    },
    /// The clock of the recording robot was set.
    #[error(
        "message {number} of the file, on {topic}: its stamp is {back_s:.1} s before the one before it: cut the recording there, or put its files in order"
    )]
    StampsGoBack {
        /// The topic.
        topic: String,
        /// The number of the message, from one.
        number: u64,
        /// The step, seconds.
        back_s: f64,
    },
    /// A message that cannot be used.
    #[error("message {number} of the file, on {topic}: {reason}")]
    InvalidMessage {
        /// Its topic.
        topic: String,
        /// Its number, from one.
        number: u64,
        /// The cause.
        reason: String,
    },
    /// Messages that are not in CDR.
    #[error(
        "the messages on {topic} are in {encoding}: convert the file to a ROS 2 recording in MCAP"
    )]
    OtherEncoding {
        /// The topic.
        topic: String,
        /// The encoding.
        encoding: String,
    },
    /// The file is damaged.
    #[error(
        "the file is damaged after {messages} messages: {reason}; use another copy of the file"
    )]
    DamagedLog {
        /// Number of messages before the damage.
        messages: u64,
        /// The cause.
        reason: String,
    },
    /// The size of the map is invalid.
    #[error("the recording's map: {0}")]
    Map(MapError),
    /// A setting is out of range.
    #[error("the recording's configuration: {0}")]
    Config(SettingError),
    /// The drive cannot start.
    #[error("the recorded drive cannot start: {0}")]
    Fault(Fault),
    /// A program planned the paths of the drive, and the replay is not permitted to run one.
    #[error(
        "its paths are of the program `{command}`, and a replay runs no command of a file: give the global planner to run"
    )]
    PlannerNotGiven {
        /// The command in the recording.
        command: String,
    },
    /// A global planner for a drive whose paths are inbye's own.
    #[error("its paths are inbye's own: leave the global planner out")]
    NoPlanner,
}

// The texts have their sources: `#[from]` would show them twice.
impl From<MapError> for RecordingError {
    fn from(error: MapError) -> Self {
        Self::Map(error)
    }
}

impl From<SettingError> for RecordingError {
    fn from(error: SettingError) -> Self {
        Self::Config(error)
    }
}

impl From<Fault> for RecordingError {
    fn from(fault: Fault) -> Self {
        Self::Fault(fault)
    }
}

/// The format that this version writes and reads.
pub const FORMAT: u32 = 7;
