//! At a stop: parking, standing, going on.

use std::sync::Arc;

use super::inflated_bodies::InflatedBodies;
use super::navigator::{Decision, Navigator};
use super::parking::{Parking, ParkingStep};
use super::predicted_state::PredictedState;
use super::progress_checker::ProgressChecker;
use super::recovery::Recovery;
use super::{Fault, Mode, Route};
use crate::geometry::{Twist, wrap_angle};
use crate::local::ClearanceField;

/// A parking robot looks so far ahead whether its way is clear, seconds, in steps of so much: longer than it takes to stop.
const LOOKS_AHEAD_S: f64 = 1.0;
const LOOKS_EVERY_S: f64 = 0.1;

impl Navigator {
    /// Near its stop: to the point, to the yaw, and stand.
    pub(super) fn park(
        &mut self,
        now: &PredictedState,
        field: &Arc<ClearanceField>,
    ) -> Result<Decision, Fault> {
        let lasted_s = self.parking.lasted_s(now.time_s);
        let goal = *self.tour.goal();
        if lasted_s > self.settings.parking_timeout_s {
            let off_m = (goal.position - now.pose.position()).norm();
            let off_rad = goal.yaw.map_or(0.0, |yaw| wrap_angle(yaw - now.pose.yaw));
            if off_m <= self.settings.xy_goal_tolerance
                && off_rad.abs() <= self.settings.yaw_goal_tolerance
            {
                return Ok(self.arrive(now));
            }
            if lasted_s > self.settings.parking_timeout_s + self.settings.movement_time_allowance {
                return Err(Fault::NoProgress {
                    stuck_s: lasted_s,
                    radius_m: self.settings.xy_parking_tolerance,
                    left_m: off_m,
                });
            }
        }
        let (settings, limits) = (&self.settings, &self.robot.limits);
        let step = self
            .parking
            .step(now.time_s, (&now.pose, &now.twist), &goal, settings, limits);
        let ParkingStep::Move(wanted) = step else {
            return Ok(self.arrive(now));
        };
        let kept = InflatedBodies::new(&self.robot.footprint, settings, field, now);
        let command = self.safe_towards(now, &wanted);
        if let Some(decision) = self.evade(now, field) {
            return Ok(decision);
        }
        self.mode = Mode::Parking;
        if !is_clear(&command, now, &kept, field) {
            return Ok(self.stand(now, Mode::Parking));
        }
        Ok(Decision {
            command,
            ..self.stand(now, Mode::Parking)
        })
    }

    /// It stands as asked: at the last stop for good, at another for a while.
    fn arrive(&mut self, now: &PredictedState) -> Decision {
        self.mode = Mode::Arrived;
        if self.tour.goes_on() {
            self.mode = Mode::AtWaypoint;
            self.tour
                .stand_until(now.time_s + self.settings.waypoint_pause_s);
        }
        self.stand(now, self.mode)
    }

    /// Stands at a stop of a tour, and goes on when it is time.
    pub(super) fn stop_over(&mut self, now: &PredictedState) -> Decision {
        if let Some(plan) = self.tour.next(now.time_s) {
            self.replanning.forget();
            self.follow(plan);
            self.watch = ProgressChecker::default();
            self.recovery = Recovery::default();
            self.parking = Parking::default();
            self.mode = Mode::Driving;
        }
        self.stand(now, self.mode)
    }

    /// Makes a plan the one that is followed.
    pub(super) fn follow(&mut self, plan: crate::global::Plan) {
        self.route = Route::new(&plan, &self.settings);
        self.plans.push(plan);
    }
}

/// Whether a robot that goes on with a velocity stays clear of everything for as long as it looks ahead. One that stands
/// is.
fn is_clear(
    command: &Twist,
    now: &PredictedState,
    kept: &InflatedBodies,
    field: &ClearanceField,
) -> bool {
    let steps = (LOOKS_AHEAD_S / LOOKS_EVERY_S) as u32;
    *command == Twist::STOP
        || (1..=steps).all(|step| {
            let time_s = f64::from(step) * LOOKS_EVERY_S;
            kept.is_clear_at(field, &now.pose.after(command, time_s), time_s)
        })
}
