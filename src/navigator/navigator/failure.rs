//! How a mission ends, and why it fails.

use super::Navigator;
use crate::geometry::Point;
use crate::navigator::controller_host::ControllerHost;
use crate::navigator::{Fault, Mode};

impl Navigator {
    pub(super) const fn is_over(&self) -> bool {
        matches!(self.mode, Mode::Arrived | Mode::Failed)
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
        if self.stuck_ticks.is_blocked() {
            let reason = self.controller.as_ref().and_then(ControllerHost::why_blocked);
            return Fault::NoControl { stuck_s, left_m, reason };
        }
        let (radius_m, held_by) = (self.settings.required_movement_radius, self.stuck_ticks.text());
        Fault::NoProgress { stuck_s, radius_m, left_m, held_by }
    }
}
