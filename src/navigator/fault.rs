//! Why a mission cannot go on, in Nav2's words.

use thiserror::Error;

use super::Doubt;
use crate::global::PlanError;
use crate::local::ChooseError;

/// What ended a mission, or kept it from starting.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum Fault {
    /// No path, or an endpoint that no path can have.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The local planner could not decide.
    #[error(transparent)]
    Choose(#[from] ChooseError),
    /// Nothing admissible for longer than the patience allows, whatever was tried.
    #[error(
        "NO_VALID_CONTROL: {stuck_s:.0} s without an admissible velocity, {left_m:.1} m from the goal: something stands \
         within the margins on all sides"
    )]
    NoControl {
        /// How long, seconds.
        stuck_s: f64,
        /// Path left, metres.
        left_m: f64,
    },
    /// No progress along the path for longer than the patience allows.
    #[error(
        "FAILED_TO_MAKE_PROGRESS: {stuck_s:.0} s without {radius_m} m of progress, {left_m:.1} m from the goal"
    )]
    NoProgress {
        /// How long, seconds.
        stuck_s: f64,
        /// What would have counted, metres.
        radius_m: f64,
        /// Path left, metres.
        left_m: f64,
    },
    /// The system gives no thread to plan on.
    #[error("no thread to plan on: {reason}")]
    NoThread {
        /// As the system says it.
        reason: String,
    },
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
    /// Senses that could not be believed for longer than the patience allows.
    #[error("INVALID_OBSERVATION: {doubt}, {times} times in a row; the robot stops")]
    BadObservation {
        /// Why the last of them was not believed.
        doubt: Doubt,
        /// How many.
        times: u32,
    },
}

impl Fault {
    /// Nav2's number of the error (`nav2_msgs`), where it has one.
    #[must_use]
    pub const fn nav2_code(&self) -> Option<u16> {
        match self {
            Self::Plan(PlanError::StartOutsideMap { .. }) => Some(203),
            Self::Plan(PlanError::GoalOutsideMap { .. }) => Some(204),
            Self::Plan(PlanError::StartOccupied { .. }) => Some(205),
            Self::Plan(PlanError::GoalOccupied { .. }) => Some(206),
            Self::Plan(PlanError::NoValidPath { .. }) => Some(208),
            Self::NoProgress { .. } => Some(105),
            Self::NoControl { .. } => Some(106),
            Self::Plan(PlanError::BadSetting { .. })
            | Self::Choose(_)
            | Self::NoThread { .. }
            | Self::BadSetting { .. }
            | Self::BadObservation { .. } => None,
        }
    }
}
