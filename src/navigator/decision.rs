//! The decision of a tick.

use serde::Serialize;

use crate::geometry::{Point, Twist};
use crate::local::Counts;

/// What the navigator does at a tick: the behaviour that decided it, or the state of the mission.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Mode {
    /// The robot follows the path with the command of the local planner.
    Driving,
    /// The robot rotates in place towards the path.
    Rotating,
    /// The robot brakes: the local planner found no admissible sample.
    Blocked,
    /// The robot leaves a place where it was stuck.
    Escaping,
    /// The robot stands at the goal.
    Arrived,
    /// The mission has failed; [`Navigator::fault`](super::Navigator::fault) has the reason.
    Failed,
    /// The robot drives the last decimetres to a goal.
    Parking,
    /// The robot stands at a waypoint and goes on after a pause.
    AtWaypoint,
    /// The robot avoids an approaching moving obstacle.
    Evading,
    /// The robot brakes: the observation is faulty.
    SensorFault,
}

impl Mode {
    /// Returns the name used in JSON and diagnostics.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Driving => "driving",
            Self::Rotating => "rotating",
            Self::Blocked => "blocked",
            Self::Escaping => "escaping",
            Self::Arrived => "arrived",
            Self::Failed => "failed",
            Self::Parking => "parking",
            Self::AtWaypoint => "at_waypoint",
            Self::Evading => "evading",
            Self::SensorFault => "sensor_fault",
        }
    }
}

/// The decision of a tick.
#[derive(Clone, Debug, PartialEq)]
pub struct Decision {
    /// The velocity to send to the base.
    pub command: Twist,
    /// What the navigator does.
    pub mode: Mode,
    /// The key node that the robot drives to.
    pub local_target: Point,
    /// Number of samples by outcome; nothing where the tick needed no sampling.
    pub counts: Option<Counts>,
}

impl Decision {
    /// A decision without sampling.
    pub(super) const fn new(command: Twist, mode: Mode, local_target: Point) -> Self {
        Self { command, mode, local_target, counts: None }
    }
}
