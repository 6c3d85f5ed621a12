//! Turning on the spot, where there is room for it.

use core::f64::consts::TAU;

use super::exact_clearance::ExactClearance;
use super::inflated_bodies::InflatedBodies;
use super::navigator::Navigator;
use super::predicted_state::PredictedState;
use crate::geometry::Pose;
use crate::local::ClearanceField;

/// A turn is looked over at steps of this, radians: 4 cm at the ends of a robot of 0.84 m.
const STEP_RAD: f64 = 0.1;
/// What the ends keep from all that stands, metres: for a pose that is known to a centimetre, and what is between steps.
const LEAST_GAP_M: f64 = 0.03;

impl Navigator {
    /// The turn on the spot to a yaw so much off that touches nothing: the shorter way round, else the longer one, radians.
    pub(super) fn clear_turn(
        &self,
        now: &PredictedState,
        kept: &InflatedBodies,
        field: &ClearanceField,
        angle: f64,
    ) -> Option<f64> {
        let footprint = &self.robot.footprint;
        let reach_m = footprint.circumscribed_radius_m() + LEAST_GAP_M;
        let exact_clearance = ExactClearance::new(field, &now.pose.position(), reach_m);
        let is_clear = |angle: &f64| {
            let steps = (angle.abs() / STEP_RAD).ceil().max(1.0);
            (1..=steps as u32).all(|step| {
                let yaw = now.pose.yaw + angle * f64::from(step) / steps;
                let there = Pose { yaw, ..now.pose };
                exact_clearance.gap_m(footprint, &there) >= LEAST_GAP_M
                    && kept.is_clear_of_moving(&there, 0.0)
            })
        };
        [angle, angle - TAU.copysign(angle)]
            .into_iter()
            .find(is_clear)
    }
}
