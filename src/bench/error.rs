//! What can be wrong with a measurement.

use thiserror::Error;

use crate::local::{EngineError, ProblemError};

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
    /// A problem that the engines do not take.
    #[error("{which}: {error}")]
    Problem {
        /// Which problem.
        which: String,
        /// Why.
        error: ProblemError,
    },
    /// An engine that gave no answer.
    #[error("{which}: {error}")]
    Engine {
        /// Which problem.
        which: String,
        /// Why.
        error: EngineError,
    },
    /// An engine whose answer differs from the first engine's: its times would be worth nothing.
    #[error("{which}: {engine} gave other bits than {first}: run `inbye verify`")]
    Differs {
        /// Which problem.
        which: String,
        /// The engine.
        engine: String,
        /// The first engine.
        first: String,
    },
}
