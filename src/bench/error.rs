//! What can be wrong with a measurement.

use thiserror::Error;

/// A measurement that cannot be used.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum BenchError {
    /// A time that no clock can have measured.
    #[error(
        "a measured time is {seconds} s: it must be finite and not below zero; take both readings from one monotonic clock"
    )]
    NotATime {
        /// As given.
        seconds: f64,
    },
}
