//! The node as a managed one.

use super::NodeCore;
use crate::geometry::Twist;
use crate::ros::convert::nanoseconds;
use crate::ros::msg::{LifecycleAnswer, LifecycleRequest};
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
            if next != LifecycleState::Active && self.goal.is_some() && self.ended_s.is_none() {
                self.navigator = None;
                self.abort(now_s, UNKNOWN, &"the node was deactivated");
            }
        }
        let transition = if next.is_some() { transition } else { 0 };
        let state = self.lifecycle.id();
        let nanoseconds = nanoseconds(now_s);
        self.states.push(LifecycleAnswer { request, transition, state, nanoseconds });
    }

    /// Rejects a goal unless the node is active.
    pub(super) fn check_active(&self) -> Result<(), MessageError> {
        if self.lifecycle == LifecycleState::Active {
            return Ok(());
        }
        Err(MessageError::NotActive { state: self.lifecycle.label() })
    }
}
