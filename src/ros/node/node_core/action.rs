//! Goals of the action `navigate_to_pose`.

use super::NodeCore;
use crate::navigator::{Decision, Mode};
use crate::ros::msg::{
    ActionAnswer, ActionCancel, ActionCancelAnswer, ActionEnd, ActionFeedback, ActionGoal,
    ActionResultRequest, Duration, Header, NavigateToPoseFeedback, Pose, PoseStamped, Time,
};
use crate::ros::node::action::{ActionUpdate, ActiveGoal, UNKNOWN};
use crate::ros::node::incoming::GoalInput;
use crate::ros::node::notices::MessageError;

/// Interval of the feedback, seconds.
const FEEDBACK_INTERVAL_S: f64 = 0.2;
/// Number of requests for a result to remember.
const MAX_RESULT_REQUESTS: usize = 64;
/// A robot that stands is assumed to drive at this share of its largest speed, for the time that remains.
const LEAST_SPEED: f64 = 0.1;

impl NodeCore {
    /// Takes a goal of a client in place of every other one, or rejects it.
    pub(super) fn navigate(
        &mut self,
        now_s: f64,
        request: &ActionGoal,
    ) -> Result<(), MessageError> {
        let ActionGoal { id, goal } = request;
        let result = GoalInput::new(&goal.pose).and_then(|goal| self.set_goal(now_s, &goal));
        if result.is_ok() {
            let goal = ActiveGoal::new(*id, now_s);
            self.updates.push(goal.answer());
            self.action = Some(goal);
        } else {
            let (accepted, stamp) = (false, Time::from_seconds(now_s));
            self.updates.push(ActionUpdate::Answer(ActionAnswer { id: *id, accepted, stamp }));
        }
        result
    }

    /// Lets the robot brake, if the request is for its goal: by its identity, by the time at which it was accepted, or as every goal.
    /// A goal of the topic has no identity; in Nav2 it goes through the action, and is cancelled with every goal.
    pub(super) fn cancel(&mut self, now_s: f64, request: ActionCancel) {
        let ActionCancel { request, id, stamp } = request;
        let is_early = Time::from_seconds(self.accepted_s) <= stamp;
        let is_meant = if stamp.is_zero() { id == [0; 16] } else { is_early };
        let is_open = self.has_open_goal();
        // A goal that has reached its end cannot be cancelled any more.
        let active = self.action.as_mut().filter(|goal| is_meant || goal.id == id);
        let is_of_topic = is_meant && active.is_none() && is_open;
        let accepted = active.is_some() || is_of_topic;
        let id = active.map_or(if is_of_topic { [0; 16] } else { id }, |goal| {
            goal.is_canceled = true;
            goal.id
        });
        self.updates.push(ActionUpdate::CancelAnswer(ActionCancelAnswer { request, accepted, id }));
        if accepted && self.ended_s.is_none() {
            self.ended_s = Some(now_s);
            self.navigator = None;
            self.notices.push("the goal was cancelled");
        }
    }

    /// The goal of a client has ended. One that it has cancelled ends as cancelled, whatever happens meanwhile.
    pub(super) fn end_action(&mut self, status: i8, error: Option<(u16, String)>) {
        if let Some(goal) = self.action.take() {
            let is_canceled = goal.is_canceled;
            let (status, error) =
                if is_canceled { (ActionEnd::CANCELED, None) } else { (status, error) };
            let end = goal.end(status, error);
            self.last_action = vec![goal.answer(), end.clone()];
            self.updates.push(end);
            // The network process answers them.
            self.result_requests.clear();
        }
    }

    /// Keeps a request for the result of the present goal: the network process that got it may end before the goal.
    pub(super) fn keep_result_request(&mut self, request: ActionResultRequest) {
        let is_present = self.action.is_some_and(|goal| goal.id == request.id);
        if is_present && self.result_requests.len() < MAX_RESULT_REQUESTS {
            self.result_requests.push(request);
        }
    }

    /// Lets a new network process, which knows the end of the last goal, answer the requests that were lost, once the nodes know
    /// each other.
    pub(super) fn send_lost_requests(&mut self, now_s: f64) {
        if now_s >= self.zero_until_s {
            self.updates.extend(self.lost_requests.drain(..).map(ActionUpdate::Result));
        }
    }

    /// The transport is a new one, which knows no goal. The present goal ends, and so does the drive. The transport gets the last
    /// goal and its end for clients that ask again.
    pub(super) fn restore_action(&mut self, now_s: f64) {
        if self.action.is_some() && self.ended_s.is_none() {
            self.navigator = None;
            self.abort(now_s, UNKNOWN, &"the network process was restarted: send the goal again");
        }
        self.end_action(ActionEnd::CANCELED, None);
        self.updates.clone_from(&self.last_action);
    }

    /// A cancelled goal ends when the robot stands.
    pub(super) fn end_cancelled(&mut self, stands: bool) {
        if stands && self.action.is_some_and(|goal| goal.is_canceled) {
            self.end_action(ActionEnd::CANCELED, None);
        }
    }

    /// Adds feedback at its interval.
    pub(super) fn add_feedback(&mut self, now_s: f64, decision: Option<&Decision>) {
        let (Some(goal), Some(navigator), Some(map), Some(decision)) =
            (&mut self.action, &self.navigator, &self.inputs.map, decision)
        else {
            return;
        };
        let is_escaping = decision.mode == Mode::Escaping;
        if is_escaping && !goal.is_escaping {
            goal.recoveries = goal.recoveries.saturating_add(1);
        }
        goal.is_escaping = is_escaping;
        if (0.0..FEEDBACK_INTERVAL_S).contains(&(now_s - goal.feedback_s)) {
            return;
        }
        goal.feedback_s = now_s;
        let left_m = navigator.distance_left_m();
        let least = LEAST_SPEED * self.settings.config.robot.limits.max_vel_x;
        let speed = self.command.linear.abs().max(least);
        let stamp = Time::from_seconds(now_s);
        let header = Header { stamp, frame_id: map.frame.clone() };
        let pose = Pose::from(&self.pose);
        let feedback = NavigateToPoseFeedback {
            current_pose: PoseStamped { header, pose },
            navigation_time: duration(now_s - goal.accepted_s),
            estimated_time_remaining: duration(left_m / speed),
            number_of_recoveries: goal.recoveries,
            distance_remaining: left_m as f32,
        };
        self.updates.push(ActionUpdate::Feedback(ActionFeedback { id: goal.id, feedback }));
    }
}

fn duration(time_s: f64) -> Duration {
    let Time { sec, nanosec } = Time::from_seconds(time_s);
    Duration { sec, nanosec }
}
