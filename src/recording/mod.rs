//! Recordings of drives that ROS 2 tools open, and their replay.
//!
//! A recording is an MCAP file (<https://mcap.dev>) with the profile `ros2`: messages in CDR with `ros2msg` schemas, as
//! `rosbag2` writes them. Times count from the start of the drive.
//!
//! ROS messages round ranges to float32. `inbye_msgs/Tick` therefore holds observation and decision to the bit. The file also
//! holds configuration, waypoints and map. From these, [`replay()`] creates the navigator again, gives it the recorded
//! observations and compares every decision.
//!
//! **Memory.** A recorder buffers at most 64 ticks for the disk. The file buffers at most a chunk of 1 MiB and a tick, or the
//! map if it is larger, and an index of a few hundred bytes per chunk. A reader buffers one chunk and the map.
//!
//! **Errors.** A full or broken disk ends the recording, never the drive. In real time, a slow disk does so too. A reader can
//! read all data before the error, and a truncated file up to its last whole chunk. A chunk ends every 2 s.

mod controller_reply;
mod error;
mod mcap_reader;
mod messages;
mod metadata;
mod reader;
mod recorder;
mod replay;
#[cfg(feature = "logs")]
mod ros_log;
mod tick;
mod writer;

pub use error::{FORMAT, RecordingError};
pub use metadata::{DriveMetadata, DriveSummary};
pub use reader::Reader;
pub use recorder::{BackpressurePolicy, Recorder, RecordingReport};
pub use replay::{Difference, FieldValue, Replay, replay};
#[cfg(feature = "logs")]
pub use ros_log::{RosLogReader, RosLogWarning};
pub use tick::RecordedTick;
