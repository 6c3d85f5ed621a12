//! What a simulated world cannot be made of.

use thiserror::Error;

use crate::localization::LocalizationError;
use crate::navigator::Fault;
use crate::robot::RobotError;
use crate::runtime::{ConfigError, MissionError};
use crate::settings::{SettingError, require};

/// Refuses a setting that is not finite and above zero.
pub(super) const fn above_zero(name: &'static str, value: f64) -> Result<(), SettingError> {
    let is_valid = value.is_finite() && value > 0.0;
    require(is_valid, name, value, "finite and above zero")
}

/// Refuses a setting that is not finite and at least zero.
pub(super) const fn at_least_zero(name: &'static str, value: f64) -> Result<(), SettingError> {
    let is_valid = value.is_finite() && value >= 0.0;
    require(is_valid, name, value, "finite and at least zero")
}

impl From<MissionError> for SimError {
    fn from(error: MissionError) -> Self {
        match error {
            MissionError::Config(error) => error.into(),
            MissionError::Localization(error) => error.into(),
            MissionError::Fault(fault) => fault.into(),
        }
    }
}

/// A description of a simulation that cannot be run.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SimError {
    /// A robot that cannot be.
    #[error(transparent)]
    Robot(#[from] RobotError),
    /// A localizer that cannot start.
    #[error(transparent)]
    Localization(#[from] LocalizationError),
    /// A configuration that is out of range.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// A navigator that cannot start.
    #[error(transparent)]
    Fault(#[from] Fault),
    /// A setting is out of range.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// A file that could not be read.
    #[error("{file}: cannot be read ({reason}): check the name and your right to read it")]
    Unreadable {
        /// The file.
        file: String,
        /// In the system's words.
        reason: String,
    },
    /// A file of moving obstacles that is not what it should be.
    #[error(
        "{file}: not a list of moving obstacles ({reason}): give JSON such as [{{\"x\": 1.0, \"y\": 2.0, \"radius\": 0.3, \"speed\": 0.5, \"route\": [[4.0, 2.0]]}}], or TOML with an [[obstacles]] table for each"
    )]
    NotObstacles {
        /// The file.
        file: String,
        /// The parser's words, in one line.
        reason: String,
    },
    /// What is wrong with one moving obstacle of a file.
    #[error("{file}: obstacle {index}: {reason}")]
    InObstacle {
        /// The file.
        file: String,
        /// Position in the list, from zero.
        index: usize,
        /// What is wrong.
        reason: Box<SimError>,
    },
    /// A key that a moving obstacle needs.
    #[error(
        "{key} is missing: an obstacle has x, y and speed, and a route or wander_m if it walks; or keyframes, and loop_s if they repeat"
    )]
    KeyMissing {
        /// The key.
        key: &'static str,
    },
    /// Two keys of a moving obstacle that cannot both be.
    #[error("{key} and {other} exclude each other: leave one of them out")]
    KeysExclude {
        /// One.
        key: &'static str,
        /// The other.
        other: &'static str,
    },
    /// A moving obstacle that would leave the map.
    #[error(
        "({x}, {y}) lies outside the map, which ends within ({width_m} m, {height_m} m) of its origin: move the point or the map"
    )]
    ObstacleOutside {
        /// The point, metres.
        x: f64,
        /// The point, metres.
        y: f64,
        /// Extent of the map along its own x axis.
        width_m: f64,
        /// Extent of the map along its own y axis.
        height_m: f64,
    },
    /// A place from which a wanderer cannot walk.
    #[error(
        "({x}, {y}) has no free ground about it for a radius of {radius_m} m to wander over within {reach_m} m: move it, or make it smaller"
    )]
    NowhereToGo {
        /// The start, metres.
        x: f64,
        /// The start, metres.
        y: f64,
        /// Radius of the obstacle, metres.
        radius_m: f64,
        /// How far from its start it may walk, metres.
        reach_m: f64,
    },
    /// No room for as many moving obstacles along the robot's path.
    #[error(
        "only {placed} of {asked} moving obstacles found a free walk of {least_m} to {most_m} m along the path: ask for fewer, or give a file of obstacles"
    )]
    NoRoom {
        /// How many found one.
        placed: usize,
        /// How many were asked for.
        asked: usize,
        /// Shortest walk, metres.
        least_m: f64,
        /// Longest walk, metres.
        most_m: f64,
    },
}
