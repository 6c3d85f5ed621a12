//! Messages of Nav2: costmap filters, and the action `navigate_to_pose`.

use super::declaration::messages;
use super::{Duration, Header, PoseStamped, Time};

messages! {
    /// What the mask of a costmap filter means.
    #[derive(Default)]
    nav2_msgs / CostmapFilterInfo {
        /// Time and frame.
        header: Header,
        /// Kind of filter: [`Self::KEEPOUT`], [`Self::SPEED_PERCENT`] or [`Self::SPEED_ABSOLUTE`].
        r#type: u8,
        /// Topic of the mask.
        filter_mask_topic: String,
        /// Added to a scaled value of the mask.
        base: f32,
        /// Scale of the values of the mask.
        multiplier: f32,
    }

    /// A speed limit.
    #[derive(Default)]
    nav2_msgs / SpeedLimit {
        /// Time and frame.
        header: Header,
        /// Whether the limit is in percent of the largest speed.
        percentage: bool,
        /// The limit, percent or m/s; zero for none.
        speed_limit: f64,
    }
}

impl CostmapFilterInfo {
    /// Kind of a keepout filter.
    pub const KEEPOUT: u8 = 0;
    /// Kind of a speed filter in percent.
    pub const SPEED_PERCENT: u8 = 1;
    /// Kind of a speed filter in m/s.
    pub const SPEED_ABSOLUTE: u8 = 2;
}

messages! {
    /// A goal of the action.
    #[derive(Default)]
    nav2_msgs / NavigateToPoseGoal {
        /// The goal; four zeros for the orientation leave its yaw free.
        pose: PoseStamped,
        /// Not used.
        behavior_tree: String,
    }

    /// The end of the action. Before Jazzy the result is empty: those clients ignore these bytes.
    #[derive(Default, Eq)]
    nav2_msgs / NavigateToPoseResult {
        /// Zero, or the code of the error.
        error_code: u16,
        /// The error.
        error_msg: String,
    }

    /// The progress of the action.
    #[derive(Default)]
    nav2_msgs / NavigateToPoseFeedback {
        /// Pose of the robot.
        current_pose: PoseStamped,
        /// Time since the goal was accepted.
        navigation_time: Duration,
        /// Time to the goal at the present speed, or at a tenth of the largest.
        estimated_time_remaining: Duration,
        /// Number of times that the robot left a place where it was stuck.
        number_of_recoveries: i16,
        /// Length of the path ahead, metres.
        distance_remaining: f32,
    }

    /// A goal with its identity, between the processes of the node.
    inbye_msgs / ActionGoal {
        /// Identity of the goal.
        id: [u8; 16],
        /// The goal.
        goal: NavigateToPoseGoal,
    }

    /// A request to cancel goals, between the processes of the node.
    #[derive(Copy, Eq)]
    inbye_msgs / ActionCancel {
        /// Number of the request.
        request: u64,
        /// Identity of the goal; zeros for no certain one.
        id: [u8; 16],
        /// The goals that were accepted at this time or before are cancelled too; with zero that goal alone, or every goal.
        stamp: Time,
    }

    /// A request for the result of a goal, between the processes of the node.
    #[derive(Copy, Eq)]
    inbye_msgs / ActionResultRequest {
        /// Identity of the client in DDS.
        client: [u8; 16],
        /// The client's number of the request.
        number: i64,
        /// Identity of the goal.
        id: [u8; 16],
    }

    /// Whether a goal is accepted, between the processes of the node.
    #[derive(Copy, Eq)]
    inbye_msgs / ActionAnswer {
        /// Identity of the goal.
        id: [u8; 16],
        /// Whether the robot pursues it.
        accepted: bool,
        /// Time of the answer.
        stamp: Time,
    }

    /// The goal that is being cancelled, between the processes of the node.
    #[derive(Copy, Eq)]
    inbye_msgs / ActionCancelAnswer {
        /// Number of the request.
        request: u64,
        /// Whether a goal is being cancelled.
        accepted: bool,
        /// Its identity; zeros for a goal of the topic.
        id: [u8; 16],
    }

    /// The progress of a goal, between the processes of the node.
    inbye_msgs / ActionFeedback {
        /// Identity of the goal.
        id: [u8; 16],
        /// The progress.
        feedback: NavigateToPoseFeedback,
    }

    /// The end of a goal, between the processes of the node.
    #[derive(Eq)]
    inbye_msgs / ActionEnd {
        [SUCCEEDED: i8 = 4, CANCELED: i8 = 5, ABORTED: i8 = 6]
        /// Identity of the goal.
        id: [u8; 16],
        /// `SUCCEEDED`, `CANCELED` or `ABORTED`, as in `action_msgs/GoalStatus`.
        status: i8,
        /// The result.
        result: NavigateToPoseResult,
    }
}
