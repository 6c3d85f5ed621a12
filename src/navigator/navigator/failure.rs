//! How legs and missions end, and why a mission fails.

use super::Navigator;
use crate::geometry::Point;
use crate::global::Plan;
use crate::navigator::controller_host::ControllerHost;
use crate::navigator::no_path::NoPath;
use crate::navigator::predicted_state::PredictedState;
use crate::navigator::state::State;
use crate::navigator::{DeadlineStats, Fault, Mode, Route};

impl Navigator {
    pub(super) const fn is_over(&self) -> bool {
        matches!(self.mode, Mode::Arrived | Mode::Failed)
    }

    /// Starts the next leg when the pause is over.
    pub(super) fn leave_waypoint(&mut self, now_s: f64) {
        if let Some(plan) = self.waypoints.next(now_s) {
            self.follow(plan);
            self.mode = Mode::Driving;
        }
    }

    /// The mode after a decision in this mode. A leg that has just begun may lead by a staging pose: `reverses` is then whether the robot
    /// may drive tail first. A robot that has come to a staging pose or to a stop goes on.
    pub(super) fn mode_after(
        &mut self,
        mode: Mode,
        now: &PredictedState,
        reverses: Option<bool>,
    ) -> Mode {
        let staging = reverses.and_then(|reverses| self.waypoints.choose(now.pose.yaw, reverses));
        staging.into_iter().for_each(|plan| self.follow(plan));
        if mode != Mode::Arrived {
            return mode;
        }
        if let Some(plan) = self.waypoints.leave_staging() {
            self.follow(plan);
            return Mode::Parking;
        }
        if !self.waypoints.has_next() {
            return Mode::Arrived;
        }
        self.waypoints.pause_until_s = now.time_s + self.settings.waypoint_pause_s;
        Mode::AtWaypoint
    }

    /// Begins to follow the plan to another target.
    pub(super) fn follow(&mut self, plan: Plan) {
        self.replanner.start_leg();
        self.route = Route::new(&plan, &self.settings);
        if let Some(host) = &mut self.controller {
            host.start_leg(&self.route.path);
        }
        self.turning_to = None;
        self.plans.push(plan);
        self.restart_progress();
    }

    /// Ends the mission. Distances in the reason are to the present goal, which may be a stop on the way.
    pub(super) fn fail(&mut self, mut fault: Fault) {
        if self.waypoints.has_next()
            && let Fault::NoProgress { held_by: why, .. }
            | Fault::NoControl { reason: Some(why), .. } = &mut fault
        {
            let stop = self.waypoints.passed + 1;
            *why = format!("{why}; this goal is stop {stop} of the mission");
        }
        self.fault = Some(fault);
        self.mode = Mode::Failed;
    }

    /// Ends the mission of a robot that drives no further: its controller and its global planner end. Where their answers were not
    /// valid, the mission has failed.
    pub fn finish(&mut self) {
        if self.fault.is_some() {
            return;
        }
        let controller = self.controller.as_mut().map_or(Ok(()), ControllerHost::finish);
        if let Err(fault) = controller.and_then(|()| self.replanner.finish()) {
            self.fail(fault);
        }
    }

    /// Counts a command that the protective layer changed, by the name of its action. A robot that it holds fails for that reason.
    #[cfg(feature = "sim")]
    pub(crate) fn count_protection(&mut self, action: &'static str) {
        self.stuck_ticks.count_protection(action);
    }

    /// The fault of a behaviour, with what the robot did since the last progress along its path.
    pub(super) fn with_modes(&self, mut fault: Fault) -> Fault {
        if let Fault::NoProgress { held_by, .. } = &mut fault {
            *held_by = self.stuck_ticks.text();
        }
        fault
    }

    /// Why the controller of a caller gave no velocity lately, if it did not.
    pub(crate) fn why_without_control(&self) -> Option<String> {
        self.controller.as_ref().and_then(ControllerHost::why_blocked)
    }

    /// The fault of a robot that made no progress for this long, seconds.
    pub(super) fn why_stuck(&self, stuck_s: f64, state: &State<'_>) -> Fault {
        // A robot that strayed may be far from the end of its path.
        let straight_m = (self.goal().position - state.now.pose.position()).norm();
        let left_m = self.route.left_m().max(straight_m);
        let people = match &self.replanner.no_path {
            Some(NoPath::Static(error)) => return Fault::Plan(error.clone()),
            Some(NoPath::Moving(Point { x, y })) => Some(format!(
                "moving obstacles close every path, the nearest one at ({x:.2}, {y:.2})"
            )),
            None => None,
        };
        let turned = state.turn_left_rad().filter(|_| state.is_near_goal()).map(|left_rad| {
            format!("the robot is at the goal, and must turn by {left_rad:.2} rad to its yaw")
        });
        let dust = self.dust.heavy_share().map(|share| {
            format!(
                "at least {:.1} % of the lidar's beams end on dust or drops in the air",
                100.0 * share
            )
        });
        // A controller says itself that its answers are late.
        let stats = self.deadline_stats().filter(|_| self.controller.is_none());
        let late = stats.filter(|stats| 2 * stats.misses > stats.decisions);
        let late = late.map(|DeadlineStats { misses, decisions, deadline_s, .. }| {
            let deadline_ms = 1e3 * deadline_s;
            format!(
                "{misses} of {decisions} decisions were later than the deadline of {deadline_ms} ms"
            )
        });
        let slow = (state.fastest < state.robot.limits.max_vel_x)
            .then(|| format!("the speed is limited to {:.2} m/s here", state.fastest));
        let sees_behind = state.limits_in_sight().min_vel_x <= state.robot.limits.min_vel_x;
        let unseen = (!sees_behind).then(|| {
            "the lidar does not see the space behind the robot, which it may not enter: navigator.may_enter_unseen is false".to_owned()
        });
        let no_reverse = (state.robot.limits.min_vel_x >= 0.0)
            .then(|| "the robot cannot reverse: robot.limits.min_vel_x is 0".to_owned());
        let why = |first: Option<String>| {
            let causes =
                [turned, people, late, slow, unseen, no_reverse, dust].into_iter().flatten();
            first.into_iter().chain(causes).collect::<Vec<_>>().join("; ")
        };
        if self.stuck_ticks.is_blocked() {
            let reason = why(self.why_without_control());
            let reason = (!reason.is_empty()).then_some(reason);
            return Fault::NoControl { stuck_s, left_m, reason };
        }
        let held_by = why(Some(self.stuck_ticks.text()));
        let radius_m = self.settings.required_movement_radius;
        Fault::NoProgress { stuck_s, radius_m, left_m, held_by }
    }
}
