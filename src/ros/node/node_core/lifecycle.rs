//! The node as a managed one.

use super::{NodeCore, Outgoing};
use crate::geometry::Twist;
use crate::ros::convert::nanoseconds;
use crate::ros::msg::{ActionEnd, LifecycleAnswer, LifecycleRequest};
use crate::ros::node::action::UNKNOWN;
use crate::ros::node::lifecycle::LifecycleState;
use crate::ros::node::notices::MessageError;

/// Time from the request to shut down to the end, seconds, at least.
const END_S: f64 = 1.0;

impl NodeCore {
    /// The state of the node as a managed one. A finalized node is to end.
    #[must_use]
    pub const fn lifecycle(&self) -> LifecycleState {
        self.lifecycle
    }

    /// Whether the node is finalized, the robot stands, and the answer to the request has had time to leave.
    #[must_use]
    pub fn has_ended(&self) -> bool {
        let is_over =
            |since_s: f64| self.tick_clock.last_s().is_some_and(|now_s| now_s - since_s >= END_S);
        self.finalized_s.is_some_and(is_over) && self.command == Twist::STOP
    }

    /// Changes the state. A robot that drives brakes, and its goal is aborted.
    pub(super) fn change_state(&mut self, now_s: f64, request: LifecycleRequest) {
        let LifecycleRequest { request, transition } = request;
        let next = self.lifecycle.after(transition);
        if let Some(next) = next {
            self.lifecycle = next;
            self.finalized_s = (next == LifecycleState::Finalized).then_some(now_s);
            self.notices.push(format!("the node is {}", next.label()));
            if next != LifecycleState::Active {
                self.abort_open_goal(now_s, "the node was deactivated");
            }
        }
        let transition = if next.is_some() { transition } else { 0 };
        let state = self.lifecycle.id();
        let nanoseconds = nanoseconds(now_s);
        self.states.push(LifecycleAnswer { request, transition, state, nanoseconds });
    }

    /// Returns the last messages of a node that ends now: zero velocity, and the end of its goal.
    pub fn shut_down(&mut self, now_s: f64) -> Outgoing {
        self.abort_open_goal(now_s, "the node was stopped");
        // A cancelled goal, while the robot brakes.
        self.end_action(ActionEnd::CANCELED, None);
        Outgoing {
            command: self.final_command(),
            action: std::mem::take(&mut self.updates),
            states: std::mem::take(&mut self.states),
            notices: self.notices.take(),
            ..Outgoing::default()
        }
    }

    fn abort_open_goal(&mut self, now_s: f64, cause: &'static str) {
        if self.has_open_goal() {
            self.navigator = None;
            self.abort(now_s, UNKNOWN, &cause);
        }
    }

    /// Rejects a goal unless the node is active.
    pub(super) fn check_active(&self) -> Result<(), MessageError> {
        if self.lifecycle == LifecycleState::Active {
            return Ok(());
        }
        Err(MessageError::NotActive { state: self.lifecycle.label() })
    }
}
