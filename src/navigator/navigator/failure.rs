//! How legs and missions end, and why a mission fails.

use super::Navigator;
use crate::geometry::Point;
use crate::navigator::controller_host::ControllerHost;
use crate::navigator::{Fault, Mode, Route};

impl Navigator {
    pub(super) const fn is_over(&self) -> bool {
        matches!(self.mode, Mode::Arrived | Mode::Failed)
    }

    /// Starts the next leg when the pause is over.
    pub(super) fn leave_waypoint(&mut self, now_s: f64) {
        if let Some(plan) = self.waypoints.next(now_s) {
            self.replanner.start_leg();
            self.route = Route::new(&plan, &self.settings);
            self.plans.push(plan);
            self.restart_progress();
            if let Some(host) = &mut self.controller {
                host.start_leg(&self.route.path);
            }
            self.mode = Mode::Driving;
        }
    }

    pub(super) fn fail(&mut self, fault: Fault) {
        self.fault = Some(fault);
        self.mode = Mode::Failed;
    }

    /// Counts a command that the protective layer changed, by the name of its action. A robot that it holds fails for that reason.
    #[cfg(feature = "sim")]
    pub(crate) fn count_protection(&mut self, action: &'static str) {
        self.stuck_ticks.count_protection(action);
    }

    /// The fault of a robot that made no progress for this long, seconds.
    pub(super) fn why_stuck(&self, stuck_s: f64, robot: &Point) -> Fault {
        // A robot that strayed may be far from the end of its path.
        let straight_m = (self.waypoints.goal.position - robot).norm();
        let left_m = self.route.left_m().max(straight_m);
        if let Some(error) = &self.replanner.no_path {
            return Fault::Plan(error.clone());
        }
        let dust = self.dust.dusty_share().map(|share| {
            format!("{:.1} % of the lidar's beams end on dust or drops in the air", 100.0 * share)
        });
        if self.stuck_ticks.is_blocked() {
            let controller = self.controller.as_ref();
            let reason = controller.and_then(ControllerHost::why_blocked).or_else(|| dust.clone());
            return Fault::NoControl { stuck_s, left_m, reason };
        }
        let held_by = [Some(self.stuck_ticks.text()), dust].into_iter().flatten();
        let held_by = held_by.collect::<Vec<_>>().join("; ");
        let radius_m = self.settings.required_movement_radius;
        Fault::NoProgress { stuck_s, radius_m, left_m, held_by }
    }
}
