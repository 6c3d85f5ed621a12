//! `sensor_msgs`.

use serde::{Deserialize, Serialize};

use super::Header;

/// `sensor_msgs/LaserScan`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LaserScan {
    /// Time of the first beam, and the lidar's frame.
    pub header: Header,
    /// Direction of the first beam, radians.
    pub angle_min: f32,
    /// Direction of the last.
    pub angle_max: f32,
    /// From one beam to the next.
    pub angle_increment: f32,
    /// Time from one beam to the next, seconds.
    pub time_increment: f32,
    /// Time from one scan to the next, seconds; not used.
    pub scan_time: f32,
    /// Ranges below it are no measurements, metres.
    pub range_min: f32,
    /// Nor are those above it.
    pub range_max: f32,
    /// A range for each beam, metres; REP 117: infinite where nothing is, NaN for no measurement.
    pub ranges: Vec<f32>,
    /// Strength of the returns; not used.
    pub intensities: Vec<f32>,
}
