//! What the node reports: rejected messages, missing inputs, notices for the user at their first occurrence, and counters.

use std::collections::{BTreeMap, HashSet};
use std::mem::{Discriminant, discriminant, take};

use serde::Serialize;
use thiserror::Error;

use crate::map::MapError;
use crate::navigator::{Mode, Navigator};
use crate::settings::SettingError;

/// Why a message is rejected. A rejected message changes nothing.
#[derive(Debug, Error)]
pub enum MessageError {
    #[error("it cannot be decoded ({reason}): the topic's type must be {expected}")]
    Undecodable { reason: String, expected: &'static str },
    #[error("{0} is not finite")]
    NotFinite(&'static str),
    #[error(
        "the quaternion of {field} has length {length}: it must be 1; (0, 0, 0, 1) is no rotation"
    )]
    BadQuaternion { field: &'static str, length: f64 },
    #[error("{0} is tilted: its z axis must point up, because the robot drives in a plane")]
    Tilted(&'static str),
    #[error("it is in the frame `{found}`, the map in `{expected}`: send it in the map's frame")]
    WrongFrame { found: String, expected: String },
    #[error("its {0} is empty: name the frame")]
    NoFrame(&'static str),
    #[error("it has {found} cells, but {width} columns and {height} rows")]
    WrongCellCount { found: usize, width: u32, height: u32 },
    #[error("cell {index} is {value}: it must be 0 to 100, or -1 for unknown")]
    BadCell { index: usize, value: i8 },
    /// The size or the resolution of a map is invalid.
    #[error(transparent)]
    Map(#[from] MapError),
    #[error(
        "it has {found} ranges, but {expected} beams from angle_min to angle_max by angle_increment"
    )]
    WrongBeamCount { found: usize, expected: f64 },
    #[error(transparent)]
    OutOfRange(#[from] SettingError),
    /// A scan is a repetition or older than the last.
    #[error(
        "its stamp is not after the stamp of the last scan: check the clock of the lidar's driver"
    )]
    NotNewer,
}

/// The input that the node waits for. Meanwhile the robot brakes to zero.
#[derive(Debug, PartialEq, Error)]
pub enum MissingInput {
    #[error("no map was received")]
    Map,
    #[error("no odometry was received")]
    Odometry,
    /// The last odometry is too old.
    #[error("odometry is no longer received")]
    RecentOdometry,
    #[error(
        "odometry is in the frame `{odometry}` and tf does not connect it to `{map}`: start a localization node, or set \
         odom_is_map"
    )]
    Transform { odometry: String, map: String },
    #[error("no scan was received")]
    Scan,
}

/// Counters since the start of the node.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct NodeStats {
    /// Accepted messages by topic.
    pub received: BTreeMap<&'static str, u64>,
    /// Rejected messages by topic.
    pub rejected: BTreeMap<&'static str, u64>,
    /// Accepted goals.
    pub goals: u64,
    /// Reached goals.
    pub reached: u64,
    /// Aborted goals, also those without a path.
    pub aborted: u64,
    /// Published velocities.
    pub commands: u64,
}

impl NodeStats {
    pub(super) fn count_message(&mut self, topic: &'static str, is_accepted: bool) {
        let counts = if is_accepted { &mut self.received } else { &mut self.rejected };
        *counts.entry(topic).or_default() += 1;
    }
}

/// Notices for the user, and those that the user has already.
#[derive(Debug, Default)]
pub struct Notices {
    pending: Vec<String>,
    rejections: HashSet<(&'static str, Discriminant<MessageError>)>,
    missing: Option<MissingInput>,
    is_mount_reported: bool,
    had_sensor_fault: bool,
}

impl Notices {
    pub fn push(&mut self, notice: impl Into<String>) {
        self.pending.push(notice.into());
    }

    /// Takes the new notices.
    pub fn take(&mut self) -> Vec<String> {
        take(&mut self.pending)
    }

    /// A message is rejected. There is one notice for each topic and kind of error.
    pub fn rejected(&mut self, topic: &'static str, error: &MessageError) {
        if self.rejections.insert((topic, discriminant(error))) {
            self.push(format!("a message on {topic} is rejected: {error}"));
        }
    }

    /// The robot waits for an input, or for none.
    pub fn missing(&mut self, missing: Option<MissingInput>) {
        if let Some(new) = missing.as_ref().filter(|_| self.missing != missing) {
            self.push(format!("waiting: {new}"));
            // Afterwards the navigator sees a gap in time: it needs no notice of its own.
            self.had_sensor_fault = true;
        }
        self.missing = missing;
    }

    /// The pose of the lidar on the robot is unknown.
    pub fn no_lidar_mount(&mut self, base_frame: &str) {
        if !self.is_mount_reported {
            self.is_mount_reported = true;
            self.push(format!(
                "tf does not have the lidar's pose on the robot: the lidar is assumed at the origin of `{base_frame}`"
            ));
        }
    }

    /// A new navigator has had no sensor fault yet.
    pub const fn reset_sensor_fault(&mut self) {
        self.had_sensor_fault = false;
    }

    /// Reports a sensor fault at its first tick.
    pub fn sensor_fault(&mut self, mode: Mode, navigator: &Navigator) {
        let has_sensor_fault = mode == Mode::SensorFault;
        if let Some(fault) =
            navigator.observation_fault().filter(|_| has_sensor_fault && !self.had_sensor_fault)
        {
            self.push(format!("braking: {fault}"));
        }
        self.had_sensor_fault = has_sensor_fault;
    }
}
