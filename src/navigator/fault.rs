//! Why a mission failed, under Nav2's error names where Nav2 has one.

use thiserror::Error;

use super::ObservationFault;
use crate::global::PlanError;
use crate::local::DecisionError;

/// Why a mission failed or could not start.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum Fault {
    /// There is no global path, or an end of it lies on an obstacle or off the map.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The local planner failed.
    #[error(transparent)]
    Choose(#[from] DecisionError),
    /// The robot found no admissible velocity for longer than `movement_time_allowance`, and no escape.
    #[error(
        "NO_VALID_CONTROL: {stuck_s:.0} s without an admissible velocity, {left_m:.1} m from the goal: obstacles are \
         within the margins on all sides"
    )]
    NoControl {
        /// Time without progress, seconds.
        stuck_s: f64,
        /// Remaining length of the path, metres.
        left_m: f64,
    },
    /// The robot made no progress along the path for longer than `movement_time_allowance`.
    #[error(
        "FAILED_TO_MAKE_PROGRESS: {stuck_s:.0} s without {radius_m} m of progress, {left_m:.1} m from the goal"
    )]
    NoProgress {
        /// Time without progress, seconds.
        stuck_s: f64,
        /// Length that counts as progress, metres.
        radius_m: f64,
        /// Remaining length of the path, metres.
        left_m: f64,
    },
    /// The operating system started no thread for the global planner.
    #[error("the planning thread did not start: {reason}")]
    NoThread {
        /// The error of the operating system.
        reason: String,
    },
    /// A setting is out of range.
    #[error("{name} is {value}: it must be {expected}")]
    BadSetting {
        /// Name of the setting.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The accepted range.
        expected: &'static str,
    },
    /// Observations were faulty for longer than the settings allow.
    #[error("INVALID_OBSERVATION: {fault}, {count} times in a row; the robot stops")]
    FaultyObservation {
        /// What was wrong with the last one.
        fault: ObservationFault,
        /// How many observations in a row were faulty.
        count: u32,
    },
}
