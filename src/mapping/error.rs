//! Errors of maps from logs.

use thiserror::Error;

use super::MAX_COORDINATE_M;
use crate::map::{MAX_GRID_CELLS, MAX_GRID_SIDE};

/// Why a log gives no map.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum MappingError {
    /// No beam ends near enough to the robot.
    #[error("no reading within {range_m} m: are the ranges in metres?")]
    NoReading {
        /// Longest range that is used, metres.
        range_m: f64,
    },
    /// A pose is so far from the origin that its coordinates are too coarse for a map.
    #[error(
        "a scan has the pose ({x:?}, {y:?}), farther than {MAX_COORDINATE_M:?} m from the origin: are the coordinates in metres? \
         If so, subtract the same offset from all of them"
    )]
    FarFromOrigin {
        /// Coordinate, metres.
        x: f64,
        /// Coordinate, metres.
        y: f64,
    },
    /// The scans lie too far apart for a grid.
    #[error(
        "its map has {width} x {height} cells, more than {MAX_GRID_SIDE} a side or {MAX_GRID_CELLS} in all; between two scans the \
         odometry moves by up to {step_m:.1} m, at {time_s:.3} s: remove this jump, or split the log"
    )]
    TooLarge {
        /// Columns of the map.
        width: i64,
        /// Rows of the map.
        height: i64,
        /// Longest step of the odometry from one scan to the next, metres.
        step_m: f64,
        /// Time of the scan after this step, seconds.
        time_s: f64,
    },
}
