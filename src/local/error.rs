//! Errors between a problem and its answer.

use core::fmt::{self, Display, Formatter};

use serde::Serialize;
use thiserror::Error;

use crate::settings::{SettingError, compact};

/// A problem outside the ranges in which the engines are exact, see [`Problem`](super::Problem).
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ProblemError {
    /// A quantity exceeds its limit.
    #[error("{quantity} is {}: it must be {limit}", measured(*value, unit))]
    OutOfRange {
        /// Name of the quantity.
        quantity: &'static str,
        /// Its value.
        value: f64,
        /// Unit of the value.
        unit: &'static str,
        /// Accepted range.
        limit: &'static str,
    },
    /// A quantity exceeds a limit that depends on the map's resolution.
    #[error(
        "{quantity} is {}: at this map's resolution it must be at most {limit_m:.3} m",
        measured((value * 1000.0).round() / 1000.0, "m")
    )]
    TooFar {
        /// Name of the quantity.
        quantity: &'static str,
        /// Its value, metres.
        value: f64,
        /// Limit, metres.
        limit_m: f64,
    },
    /// A number is not finite.
    #[error("{quantity} is not a finite number")]
    NotFinite {
        /// Name of the quantity.
        quantity: &'static str,
    },
    /// A moving obstacle has a number that is not finite, or a radius that is not above zero.
    #[error("moving obstacle {index} must have finite numbers and a radius above zero")]
    BadObstacle {
        /// Index in the list of obstacles.
        index: usize,
    },
}

/// Formats a value with its unit.
fn measured(value: f64, unit: &str) -> String {
    let number = compact(value);
    if unit.is_empty() { number } else { format!("{number} {unit}") }
}

/// An engine that does not open, or gives no answer.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum EngineError {
    /// The machine has no graphics adapter.
    #[error(
        "no GPU adapter found: install a driver (a software one is Debian's mesa-vulkan-drivers) or use the CPU engine"
    )]
    NoAdapter,
    /// No adapter has the requested name.
    #[error(
        "no GPU adapter's name contains `{requested}`: name one of {available}, or use the CPU engine"
    )]
    AdapterNotFound {
        /// The requested name.
        requested: String,
        /// Names of the machine's adapters.
        available: String,
    },
    /// The library is built without the feature `gpu`.
    #[error("this build has no GPU engine (feature `gpu` is off): use the CPU engine")]
    NoGpuSupport,
    /// The adapter refuses to create a device, a pipeline or a buffer.
    #[error("GPU adapter {adapter}: {message}")]
    Setup {
        /// Name of the adapter.
        adapter: String,
        /// Message of the driver.
        message: String,
    },
    /// The problem exceeds a limit of the adapter. The device stays usable.
    #[error("GPU adapter {adapter}: {message}")]
    TooLarge {
        /// Name of the adapter.
        adapter: String,
        /// The exceeded limit.
        message: String,
    },
    /// The device was lost or reported an error during a decision.
    #[error("GPU {adapter} gave no answer: {message}")]
    Lost {
        /// Name of the adapter.
        adapter: String,
        /// Kind of failure.
        kind: GpuFailureKind,
        /// Message of the device.
        message: String,
    },
    /// A GPU is required and the selected engine is the CPU.
    #[error(
        "a GPU is required, and the selected engine is the CPU ({selected}): install a driver, or choose a software adapter by name"
    )]
    GpuRequired {
        /// The selected engine.
        selected: String,
    },
    /// The processor lacks the requested vector instructions.
    #[error("this processor does not have {name} instructions")]
    UnsupportedInstructionSet {
        /// Name of the instruction set.
        name: &'static str,
    },
    /// More threads than an engine may have.
    #[error("{threads} CPU threads: an engine has at most {most}")]
    TooManyThreads {
        /// Requested number of threads.
        threads: usize,
        /// The most.
        most: usize,
    },
    /// The system refuses a thread.
    #[error("cannot start {threads} CPU threads: {message}")]
    ThreadSpawn {
        /// Requested number of threads.
        threads: usize,
        /// Message of the system.
        message: String,
    },
}

/// Kinds of GPU failures. JSON uses the names in snake case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum GpuFailureKind {
    /// There is no adapter.
    Absent,
    /// The adapter gives no device or refuses a pipeline.
    OpenFailed,
    /// The device is gone: destroyed, reset or unplugged.
    DeviceLost,
    /// No answer arrived within the timeout.
    TimedOut,
    /// The device refused a call as invalid.
    Validation,
    /// The device has no memory left.
    OutOfMemory,
    /// The driver reported an internal error.
    Internal,
    /// The answer belongs to another problem.
    Stale,
    /// The problem exceeds a limit of the adapter.
    TooLarge,
    /// The answer differs from the CPU's evaluation of its winner.
    WrongAnswer,
    /// The code that drives the device panicked.
    Panicked,
}

impl From<SettingError> for ProblemError {
    fn from(error: SettingError) -> Self {
        Self::OutOfRange {
            quantity: error.name,
            value: error.value,
            unit: "",
            limit: error.expected,
        }
    }
}

/// The name as in JSON.
impl Display for GpuFailureKind {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> fmt::Result {
        self.serialize(formatter)
    }
}

impl EngineError {
    /// The kind of this error as a failure of a GPU.
    #[must_use]
    pub const fn failure_kind(&self) -> GpuFailureKind {
        match self {
            Self::NoAdapter
            | Self::AdapterNotFound { .. }
            | Self::NoGpuSupport
            | Self::GpuRequired { .. } => GpuFailureKind::Absent,
            Self::Lost { kind, .. } => *kind,
            Self::TooLarge { .. } => GpuFailureKind::TooLarge,
            Self::Setup { .. }
            | Self::UnsupportedInstructionSet { .. }
            | Self::TooManyThreads { .. }
            | Self::ThreadSpawn { .. } => GpuFailureKind::OpenFailed,
        }
    }
}

/// A decision that fails.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum DecisionError {
    /// A quantity is out of range.
    #[error(transparent)]
    Problem(#[from] ProblemError),
    /// The engine gives no answer.
    #[error(transparent)]
    Engine(#[from] EngineError),
}
