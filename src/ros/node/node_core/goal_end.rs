//! The end of a goal.

use std::fmt::Display;

use super::NodeCore;
use crate::base::OperatorState;
use crate::geometry::{Twist, wrap_angle};
use crate::navigator::{Fault, Goal, Mode, Navigator, NavigatorSettings};
use crate::ros::msg::ActionEnd;
use crate::ros::node::action::{UNKNOWN, error_code};

/// Time for which zero velocity is published after a goal, seconds. Then the node is silent, and another may drive.
const STOP_S: f64 = 1.0;

/// Share of the goal tolerances within which two goals are the same: the robot still arrives at the newer one.
const SAME_SHARE: f64 = 0.1;

impl NodeCore {
    /// Whether a goal is the one that the robot pursues, within a tenth of its tolerances: nodes that follow something send theirs
    /// again and again.
    pub(super) fn is_present_goal(&self, frame: &str, goal: &Goal) -> bool {
        let NavigatorSettings { xy_goal_tolerance, yaw_goal_tolerance, .. } =
            self.settings.config.navigator;
        let is_same_yaw = |present: Option<f64>| match (present, goal.yaw) {
            (Some(present), Some(yaw)) => {
                wrap_angle(yaw - present).abs() <= SAME_SHARE * yaw_goal_tolerance
            }
            (present, yaw) => present == yaw,
        };
        self.ended_s.is_none()
            && self.goal.as_ref().is_some_and(|(found, present)| {
                found == frame
                    && (present.position - goal.position).norm() <= SAME_SHARE * xy_goal_tolerance
                    && is_same_yaw(present.yaw)
            })
    }

    /// Whether the node has a goal that has not ended.
    pub(super) const fn has_open_goal(&self) -> bool {
        self.goal.is_some() && self.ended_s.is_none()
    }

    pub(super) fn check_end(&mut self, now_s: f64, mode: Mode) {
        if self.ended_s.is_some() {
            return;
        }
        if mode == Mode::Arrived {
            self.stats.reached += 1;
            self.ended_s = Some(now_s);
            self.end_action(ActionEnd::SUCCEEDED, None);
            self.notices.push("reached the goal");
        }
        let fault = self.navigator.as_ref().and_then(Navigator::fault).cloned();
        if let Some(fault) = fault {
            self.abort_by(now_s, &fault);
        }
    }

    /// Aborts a goal for which no scan comes: without one the navigator, which times missing scans, is not asked. After a loss of
    /// the transport the time begins when the nodes know each other.
    pub(super) fn wait_for_scan(&mut self, now_s: f64) {
        let waits = self.ended_s.is_none()
            && self.protection.state() == OperatorState::Armed
            && now_s >= self.zero_until_s
            && !self.inputs.has_scan();
        let since_s = waits.then(|| self.without_scan_since_s.unwrap_or(now_s));
        self.without_scan_since_s = since_s;
        let patience_s = self.settings.config.navigator.sensor_fault_patience_s;
        if since_s.is_some_and(|since_s| now_s - since_s > patience_s) {
            let cause = format!("no scan was received for {patience_s} s");
            self.abort(now_s, UNKNOWN, &cause);
        }
    }

    /// A navigator's fault ends the goal.
    pub(super) fn abort_by(&mut self, now_s: f64, fault: &Fault) {
        let text = self.notices.fault_text(fault);
        let note = self.zones.note(fault);
        self.abort(now_s, error_code(fault), &format_args!("{text}{note}"));
    }

    /// The goal cannot be reached. `code` is that of the error in Nav2.
    pub(super) fn abort(&mut self, now_s: f64, code: u16, cause: &dyn Display) {
        self.end_action(ActionEnd::ABORTED, Some((code, cause.to_string())));
        self.stats.aborted += 1;
        self.ended_s = Some(now_s);
        self.notices.push(format!("aborted the goal: {cause}"));
    }

    /// Drops an ended goal after the robot has stood for a while.
    pub(super) fn drop_ended_goal(&mut self, now_s: f64) {
        let is_over = |ended_s: f64| now_s - ended_s >= STOP_S && now_s >= self.zero_until_s;
        if self.ended_s.is_some_and(is_over) && self.command == Twist::STOP {
            self.goal = None;
            self.navigator = None;
            self.ended_s = None;
        }
    }
}
