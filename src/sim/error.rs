//! Errors of the simulation.

use thiserror::Error;

use crate::input_file::InputFileError;
use crate::runtime::MissionError;
use crate::settings::{SettingError, require};

/// Rejects a number that is not finite and above zero.
pub(super) const fn above_zero(name: &'static str, value: f64) -> Result<(), SettingError> {
    let is_valid = value.is_finite() && value > 0.0;
    require(is_valid, name, value, "finite and above zero")
}

/// Rejects a number that is not finite and at least zero.
pub(super) const fn at_least_zero(name: &'static str, value: f64) -> Result<(), SettingError> {
    let is_valid = value.is_finite() && value >= 0.0;
    require(is_valid, name, value, "finite and at least zero")
}

/// Why a simulation cannot be built or run.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum SimError {
    /// The mission cannot start.
    #[error(transparent)]
    Mission(#[from] MissionError),
    /// A setting is out of range.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// The user's own simulator cannot be used.
    #[error("the simulator `{program}`: {reason}")]
    Simulator {
        /// Its command.
        program: String,
        /// The cause.
        reason: String,
    },
    /// A file cannot be read.
    #[error("{file}: {problem}")]
    UnreadableFile {
        /// The file.
        file: String,
        /// What is wrong with it.
        problem: InputFileError,
    },
    /// A file is not a list of moving obstacles.
    #[error(
        "{file}: not a list of moving obstacles ({reason}): give JSON such as [{{\"x\": 1.0, \"y\": 2.0, \"radius\": 0.3, \"speed\": 0.5, \"route\": [[4.0, 2.0]]}}], or TOML with an [[obstacles]] table for each"
    )]
    InvalidObstacleFile {
        /// The file.
        file: String,
        /// The parser's message, on one line.
        reason: String,
    },
    /// A moving obstacle of a file is invalid.
    #[error("{file}: line {line}: obstacle {index}: {reason}")]
    InvalidObstacle {
        /// The file.
        file: String,
        /// Line of the key, from one; of the obstacle, for an error of no key that the file has.
        line: usize,
        /// Index in the list, from zero.
        index: usize,
        /// The cause.
        reason: Box<SimError>,
    },
    /// A moving obstacle lacks a key.
    #[error(
        "{key} is missing: an obstacle has x, y and speed, and a route or wander_m if it moves; or keyframes, and loop_s if they repeat"
    )]
    MissingKey {
        /// The key.
        key: &'static str,
    },
    /// A moving obstacle has two mutually exclusive keys.
    #[error("{key} and {other} exclude each other: leave one of them out")]
    ConflictingKeys {
        /// One of the keys.
        key: &'static str,
        /// The other key.
        other: &'static str,
    },
    /// A moving obstacle touches the robot before anything moves.
    #[error(
        "touches the robot at its start ({x:.2}, {y:.2}): move one of them, or let the obstacle appear later with appears_at_s"
    )]
    TouchesRobot {
        /// The start of the robot, metres.
        x: f64,
        /// The start of the robot, metres.
        y: f64,
    },
    /// A point of a moving obstacle is outside the map.
    #[error(
        "({x}, {y}) lies outside the map, which ends within ({width_m} m, {height_m} m) of its origin: move the point or the map"
    )]
    OutsideMap {
        /// Key of the point.
        key: &'static str,
        /// The point, metres.
        x: f64,
        /// The point, metres.
        y: f64,
        /// Extent of the map along its own x axis.
        width_m: f64,
        /// Extent of the map along its own y axis.
        height_m: f64,
    },
    /// There is no free space around the start of a random-waypoint obstacle.
    #[error(
        "({x}, {y}) has no free space around it for a radius of {radius_m} m within {reach_m} m: move it, or make it smaller"
    )]
    NoFreeSpace {
        /// The start, metres.
        x: f64,
        /// The start, metres.
        y: f64,
        /// Radius of the obstacle, metres.
        radius_m: f64,
        /// Largest distance from the start, metres.
        reach_m: f64,
    },
    /// There is no space for all pedestrians along the robot's path.
    #[error(
        "only {placed} of {asked} moving obstacles found a free walk of {least_m} to {most_m} m along the path: ask for fewer, or give a file of obstacles"
    )]
    NoRoom {
        /// Number of pedestrians with a walk.
        placed: usize,
        /// Number of pedestrians requested.
        asked: usize,
        /// Shortest walk, metres.
        least_m: f64,
        /// Longest walk, metres.
        most_m: f64,
    },
}

impl SimError {
    /// The key of a file of moving obstacles whose value is wrong; none for an error of something else.
    pub(super) fn key(&self) -> Option<&'static str> {
        match self {
            Self::Setting(error) if error.name.contains("keyframe") => Some("keyframes"),
            Self::Setting(error) if error.name.contains("route") => Some("route"),
            Self::Setting(error) => Some(error.name),
            Self::ConflictingKeys { key, .. } | Self::OutsideMap { key, .. } => Some(key),
            _ => None,
        }
    }
}
