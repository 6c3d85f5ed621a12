//! What can be wrong with the description of a robot.

use thiserror::Error;

/// A description that no robot can have.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum RobotError {
    /// A footprint of no disc.
    #[error(
        "the footprint has no disc: give at least one, such as {{x = 0.0, y = 0.0, radius = 0.3}}"
    )]
    EmptyFootprint,
    /// A disc with a number that is not finite, or a radius that is not above zero.
    #[error(
        "footprint disc {index} is x {x}, y {y}, radius {radius}: all must be finite and the radius above zero"
    )]
    BadDisc {
        /// Position in the list, from zero.
        index: usize,
        /// As given.
        x: f64,
        /// As given.
        y: f64,
        /// As given.
        radius: f64,
    },
    /// A limit that is not finite or has the wrong sign.
    #[error("{name} is {value}: it must be {expected}")]
    BadLimit {
        /// Name as in the configuration.
        name: &'static str,
        /// As given.
        value: f64,
        /// What would be accepted.
        expected: &'static str,
    },
}
