//! The decision of a tick, and why a mission fails, under Nav2's error names where Nav2 has one.

use serde::Serialize;
use thiserror::Error;

use super::{ControllerError, ObservationFault};
use crate::geometry::{Point, Twist};
use crate::global::PlanError;
use crate::local::{Counts, DecisionError};
use crate::settings::{SettingError, words};

words! {
    /// What the navigator does at a tick: the behaviour that decided it, or the state of the mission.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
    #[non_exhaustive]
    pub enum Mode {
        /// The robot follows the path with the command of the local planner.
        Driving = "driving",
        /// The robot rotates in place towards the path.
        Rotating = "rotating",
        /// The robot brakes: the local planner found no admissible sample.
        Blocked = "blocked",
        /// The robot leaves a place where it was stuck.
        Escaping = "escaping",
        /// The robot stands at the goal.
        Arrived = "arrived",
        /// The mission has failed; [`Navigator::fault`](super::Navigator::fault) has the reason.
        Failed = "failed",
        /// The robot drives the last decimetres to a goal.
        Parking = "parking",
        /// The robot stands at a waypoint and continues after a pause.
        AtWaypoint = "at_waypoint",
        /// The robot avoids an approaching moving obstacle.
        Evading = "evading",
        /// The robot brakes: the observation is faulty.
        SensorFault = "sensor_fault",
    }
}

/// The decision of a tick.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Decision {
    /// The velocity to send to the base.
    pub command: Twist,
    /// What the navigator does.
    pub mode: Mode,
    /// The key node that the robot drives to.
    pub local_target: Point,
    /// Number of samples by outcome; `None` where the tick needed no sampling.
    pub counts: Option<Counts>,
}

impl Decision {
    /// A decision without sampling.
    pub(super) const fn new(command: Twist, mode: Mode, local_target: Point) -> Self {
        Self { command, mode, local_target, counts: None }
    }
}

/// Why a mission failed or could not start.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum Fault {
    /// There is no global path, or an end of it lies on an obstacle or off the map.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The local planner failed: a quantity was out of range, or the engine gave no answer.
    #[error("NO_DECISION: {0}")]
    Choose(#[from] DecisionError),
    /// The robot found no admissible velocity for longer than `movement_time_allowance`, and no escape.
    #[error(
        "NO_VALID_CONTROL: {stuck_s:.0} s without an admissible velocity, {left_m:.1} m from the goal: {}",
        reason.as_deref().unwrap_or("every velocity leads into the margin of an obstacle")
    )]
    NoControl {
        /// Time without progress, seconds.
        stuck_s: f64,
        /// Remaining length of the path, metres.
        left_m: f64,
        /// What kept the controller from deciding, or that the air is dusty.
        reason: Option<String>,
    },
    /// The robot made no progress along the path for longer than `movement_time_allowance`.
    #[error(
        "FAILED_TO_MAKE_PROGRESS: {stuck_s:.0} s without {radius_m} m of progress, {left_m:.1} m from the goal: {held_by}"
    )]
    NoProgress {
        /// Time without progress, seconds.
        stuck_s: f64,
        /// Length that counts as progress, metres.
        radius_m: f64,
        /// Remaining length of the path, metres.
        left_m: f64,
        /// What held the robot, or what it did meanwhile.
        held_by: String,
    },
    /// The robot stands at the position of its goal and has no room to turn to the yaw.
    #[error(
        "FAILED_TO_MAKE_PROGRESS: the robot is at the position of its goal and has no room to turn to the yaw {yaw:.2} from {from:.2}: \
         obstacles are within the safety margin"
    )]
    NoRoomToTurn {
        /// Yaw of the goal, radians.
        yaw: f64,
        /// Yaw of the robot, radians.
        from: f64,
    },
    /// The operating system started no thread for the global planner.
    #[error("the planning thread did not start: {reason}")]
    NoThread {
        /// The error of the operating system.
        reason: String,
    },
    /// A setting is out of range.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// The controller that replaces the navigator's own behaviours failed.
    #[error("{}: {name}: {error}", controller_code(error))]
    Controller {
        /// Name of the controller.
        name: String,
        /// The cause.
        error: ControllerError,
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

/// Nav2's name of a controller's error.
const fn controller_code(error: &ControllerError) -> &'static str {
    match error {
        ControllerError::TimedOut { .. } => "CONTROLLER_TIMED_OUT",
        _ => "INVALID_CONTROLLER",
    }
}
