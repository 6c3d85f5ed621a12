//! What can go wrong between a problem and its answer.

use serde::Serialize;
use thiserror::Error;

/// A problem outside the ranges for which the engines promise exact and close answers.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ProblemError {
    /// A quantity beyond its limit.
    #[error("{quantity} is {}: it must be {limit}", measured(*value, unit))]
    OutOfRange {
        /// Which.
        quantity: &'static str,
        /// Its value.
        value: f64,
        /// Unit of the value.
        unit: &'static str,
        /// What would be accepted.
        limit: &'static str,
    },
    /// A quantity beyond a limit that depends on the map's resolution.
    #[error(
        "{quantity} is {}: at this map's resolution it must be at most {limit_m:.3} m",
        measured((value * 1000.0).round() / 1000.0, "m")
    )]
    TooFar {
        /// Which.
        quantity: &'static str,
        /// Its value, metres.
        value: f64,
        /// The limit, metres.
        limit_m: f64,
    },
    /// A number that is not finite.
    #[error("{quantity} is not a finite number")]
    NotFinite {
        /// Which.
        quantity: &'static str,
    },
    /// A moving obstacle with a number that is not finite, or a radius not above zero.
    #[error("moving obstacle {index} must have finite numbers and a radius above zero")]
    BadObstacle {
        /// Position in the list, from zero.
        index: usize,
    },
}

/// A number with its unit; one too long to read in powers of ten.
fn measured(value: f64, unit: &str) -> String {
    let number = if value.is_finite() && value.abs() >= 1e9 {
        format!("{value:e}")
    } else {
        value.to_string()
    };
    if unit.is_empty() {
        number
    } else {
        format!("{number} {unit}")
    }
}

/// An engine that could not be opened, or gave no answer.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum EngineError {
    /// No graphics adapter is there.
    #[error(
        "no GPU adapter found: install a driver (a software one is Debian's mesa-vulkan-drivers) or use --engine cpu"
    )]
    NoAdapter,
    /// No adapter has the name asked for.
    #[error(
        "no GPU adapter's name contains `{wanted}`: name one of those here ({found}), or use --engine cpu"
    )]
    NoSuchAdapter {
        /// As asked for.
        wanted: String,
        /// Names of those present.
        found: String,
    },
    /// The program was built without the GPU engine.
    #[error("this build has no GPU engine (feature `gpu` is off): use --engine cpu")]
    NotBuilt,
    /// The adapter refused to make a device, a pipeline or a buffer.
    #[error("GPU adapter {adapter}: {what}")]
    Setup {
        /// The adapter's name.
        adapter: String,
        /// What it said.
        what: String,
    },
    /// A problem that the adapter cannot hold; its device is none the worse.
    #[error("GPU adapter {adapter}: {what}")]
    TooLarge {
        /// The adapter's name.
        adapter: String,
        /// What is too large.
        what: String,
    },
    /// The device was lost or reported an error while it worked.
    #[error("GPU {adapter} gave no answer: {what}")]
    Lost {
        /// The adapter's name.
        adapter: String,
        /// How.
        kind: LossKind,
        /// What it said.
        what: String,
    },
    /// No hardware adapter is there, only a program that does its work on the CPU.
    #[error("the only GPU adapter, {adapter}, is software on this CPU")]
    OnlySoftware {
        /// Its name.
        adapter: String,
    },
    /// A GPU was required, and the best engine to be had has none.
    #[error(
        "a GPU is required, and this is all there is ({best}): install a driver, or name a software adapter with --engine gpu:NAME"
    )]
    NoGpu {
        /// The best engine, and why it is that one.
        best: String,
    },
    /// The processor does not have the vector instructions asked for.
    #[error("this processor does not have {which} instructions")]
    NoInstructions {
        /// Their name.
        which: &'static str,
    },
    /// A worker pool could not be started.
    #[error("cannot start {threads} CPU threads: {what}")]
    Threads {
        /// As asked for.
        threads: usize,
        /// What the system said.
        what: String,
    },
}

/// How a GPU fails. The words are those used in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LossKind {
    /// No adapter is there.
    Absent,
    /// An adapter is there, and gives no device or refuses a pipeline.
    Unopened,
    /// The device is gone: destroyed, reset, unplugged.
    DeviceLost,
    /// No answer within the patience.
    TimedOut,
    /// A call was refused as invalid.
    Validation,
    /// The device has no memory left.
    OutOfMemory,
    /// The driver failed within.
    Internal,
    /// The answer to another problem came back.
    Stale,
    /// The problem is more than the adapter can hold.
    TooLarge,
    /// The answer does not hold when its winner is judged again.
    WrongAnswer,
    /// The code that drives the device panicked.
    Panicked,
}

impl LossKind {
    /// The word used in JSON and text.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Absent => "absent",
            Self::Unopened => "unopened",
            Self::DeviceLost => "device_lost",
            Self::TimedOut => "timed_out",
            Self::Validation => "validation",
            Self::OutOfMemory => "out_of_memory",
            Self::Internal => "internal",
            Self::Stale => "stale",
            Self::TooLarge => "too_large",
            Self::WrongAnswer => "wrong_answer",
            Self::Panicked => "panicked",
        }
    }
}

impl EngineError {
    /// What this is as the failure of a GPU.
    #[must_use]
    pub const fn loss(&self) -> LossKind {
        match self {
            Self::NoAdapter
            | Self::NoSuchAdapter { .. }
            | Self::NotBuilt
            | Self::OnlySoftware { .. }
            | Self::NoGpu { .. } => LossKind::Absent,
            Self::Lost { kind, .. } => *kind,
            Self::TooLarge { .. } => LossKind::TooLarge,
            Self::Setup { .. } | Self::NoInstructions { .. } | Self::Threads { .. } => {
                LossKind::Unopened
            }
        }
    }
}
