//! The action `navigate_to_pose`, as far as the control process knows it.

use crate::global::PlanError;
use crate::navigator::Fault;
use crate::ros::msg::{
    ActionAnswer, ActionCancelAnswer, ActionEnd, ActionFeedback, ActionResultRequest,
    NavigateToPoseResult, Time,
};

/// What the clients of the action get.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ActionUpdate {
    /// Whether a goal is accepted.
    Answer(ActionAnswer),
    /// Whether a goal is being cancelled.
    CancelAnswer(ActionCancelAnswer),
    /// The progress of a goal.
    Feedback(ActionFeedback),
    /// The end of a goal.
    End(ActionEnd),
    /// A client that asked an earlier network process gets its answer.
    Result(ActionResultRequest),
}

/// The goal of a client.
#[derive(Clone, Copy, Debug)]
pub struct ActiveGoal {
    pub id: [u8; 16],
    /// Time at which it was accepted, seconds.
    pub accepted_s: f64,
    /// Time of the last feedback, seconds.
    pub feedback_s: f64,
    pub recoveries: i16,
    /// Whether the robot was leaving a place at the last tick.
    pub is_escaping: bool,
    pub is_canceled: bool,
}

impl ActiveGoal {
    /// A goal that was accepted at a time, seconds.
    pub const fn new(id: [u8; 16], accepted_s: f64) -> Self {
        Self {
            id,
            accepted_s,
            feedback_s: f64::NEG_INFINITY,
            recoveries: 0,
            is_escaping: false,
            is_canceled: false,
        }
    }

    /// That it is accepted.
    pub fn answer(&self) -> ActionUpdate {
        let stamp = Time::from_seconds(self.accepted_s);
        ActionUpdate::Answer(ActionAnswer { id: self.id, accepted: true, stamp })
    }

    /// Its end, with the code and the text of an error.
    pub fn end(&self, status: i8, error: Option<(u16, String)>) -> ActionUpdate {
        let (error_code, error_msg) = error.unwrap_or_default();
        let result = NavigateToPoseResult { error_code, error_msg };
        ActionUpdate::End(ActionEnd { id: self.id, status, result })
    }
}

/// An error without a code of its own: `UNKNOWN` of `NavigateToPose`.
pub const UNKNOWN: u16 = 9000;

/// The code of a fault in Nav2's actions `ComputePathToPose` and `FollowPath`.
pub const fn error_code(fault: &Fault) -> u16 {
    match fault {
        Fault::Plan(PlanError::StartOutsideMap { .. }) => 203,
        Fault::Plan(PlanError::GoalOutsideMap { .. }) => 204,
        Fault::Plan(PlanError::StartOccupied { .. }) => 205,
        Fault::Plan(PlanError::GoalOccupied { .. }) => 206,
        Fault::Plan(PlanError::NoValidPath { .. }) => 208,
        Fault::NoProgress { .. } | Fault::NoRoomToTurn { .. } => 105,
        Fault::NoControl { .. } => 106,
        _ => UNKNOWN,
    }
}
