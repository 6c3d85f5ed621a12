//! What a localiser cannot begin with.

use thiserror::Error;

/// Settings or a start that no localiser can have.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum LocalizationError {
    /// A setting out of range.
    #[error("{name} is {value}: it must be {expected}")]
    BadSetting {
        /// Its name.
        name: &'static str,
        /// As given.
        value: f64,
        /// What would be accepted.
        expected: &'static str,
    },
    /// A start that is not a place.
    #[error("the start is ({x}, {y}, {yaw}): all three must be finite")]
    BadStart {
        /// As given, metres.
        x: f64,
        /// As given, metres.
        y: f64,
        /// As given, radians.
        yaw: f64,
    },
}
