//! Out of the way of somebody who does not stop.
//!
//! The dynamic window asks which velocity leads on; where none does, it stands. A robot that stands on the line of somebody
//! who walks on is hit. So a robot that would be hit where it stands looks for the motion that keeps the greatest distance
//! from everybody for some seconds, wherever that leads.

use super::Mode;
use super::inflated_bodies::InflatedBodies;
use super::navigator::{Decision, Navigator};
use super::predicted_state::PredictedState;
use crate::geometry::Twist;
use crate::local::ClearanceField;
use crate::map::MovingDisc;
use crate::robot::{Footprint, Limits};

/// So far ahead it is looked who comes, seconds, and in which steps.
const LOOKS_AHEAD_S: f64 = 3.0;
const STEP_S: f64 = 0.1;
/// Who comes nearer than this, metres, to a robot that stands is evaded; more room than this is not sought.
const EVADED_GAP_M: f64 = 0.1;
const ENOUGH_GAP_M: f64 = 0.7;
/// Slower than this nobody comes, m/s.
const COMES_FROM: f64 = 0.15;
/// A way is worth leaving for if it keeps so much more distance than standing does, metres.
const WORTH_M: f64 = 0.02;
/// Shares of the highest forward, backward and turning speeds that are tried.
const FORWARD: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];
const BACKWARD: [f64; 2] = [0.5, 1.0];
const TURNING: [f64; 9] = [0.0, 0.25, -0.25, 0.5, -0.5, 0.75, -0.75, 1.0, -1.0];

impl Navigator {
    /// The motion that keeps furthest from who comes, if somebody comes upon a robot that stands here.
    pub(super) fn evade(
        &mut self,
        now: &PredictedState,
        field: &ClearanceField,
    ) -> Option<Decision> {
        if !self.settings.features.recovery {
            return None;
        }
        let footprint = &self.robot.footprint;
        let comes = |disc: &MovingDisc| libm::hypot(disc.vx, disc.vy) >= COMES_FROM;
        let coming: Vec<MovingDisc> = now
            .moving
            .iter()
            .filter(|disc| comes(disc))
            .copied()
            .collect();
        let limits = &self.robot.limits;
        let ways = Ways {
            now,
            limits,
            footprint,
            kept: InflatedBodies::new(footprint, &self.settings, field, now),
            field,
            caution: self.settings.features.passive_safety,
        };
        if ways.least_gap_m(&Twist::STOP, &coming)? >= EVADED_GAP_M {
            return None;
        }
        // Nobody is run into for another's sake, nor because it would hurt less: who cannot get clear stands.
        let least_m = if ways.caution { 0.0 } else { f64::NEG_INFINITY };
        let standing_m = ways.least_gap_m(&Twist::STOP, &now.moving)?.max(least_m);
        let backward = BACKWARD.map(|share| share * limits.min_vel_x.min(0.0));
        let forward = FORWARD.map(|share| share * limits.max_vel_x);
        let mut best = (standing_m + WORTH_M, None);
        for linear in forward.into_iter().chain(backward) {
            for share in TURNING {
                let wanted = Twist::new(linear, share * limits.max_vel_theta);
                let Some(gap_m) = ways.least_gap_m(&wanted, &now.moving) else {
                    continue;
                };
                let gap_m = gap_m.min(ENOUGH_GAP_M);
                if gap_m > best.0
                    && ways.can_be_broken_off(&wanted)
                    && self.is_safe_towards(now, &wanted)
                {
                    best = (gap_m, Some(wanted));
                }
            }
        }
        let wanted = best.1?;
        self.mode = Mode::Evading;
        Some(Decision {
            command: self.towards(now, &wanted),
            ..self.stand(now, Mode::Evading)
        })
    }
}

/// What ways are judged by.
struct Ways<'a> {
    now: &'a PredictedState,
    limits: &'a Limits,
    footprint: &'a Footprint,
    kept: InflatedBodies,
    field: &'a ClearanceField,
    /// Whether nobody is counted on to move on.
    caution: bool,
}

impl Ways<'_> {
    /// Whether a robot that begins to make for a velocity, and brakes from the next decision on, keeps off what stands.
    fn can_be_broken_off(&self, wanted: &Twist) -> bool {
        let (mut pose, mut twist) =
            self.limits
                .advance(&self.now.pose, &self.now.twist, wanted, STEP_S);
        while twist.linear != 0.0 {
            if !self.kept.keeps_off_what_stands(self.field, &pose) {
                return false;
            }
            (pose, twist) = self.limits.advance_braking(&pose, &twist, STEP_S);
        }
        true
    }

    /// The least distance from people on a way with a velocity that is made for as fast as the limits allow; none where
    /// something that stands is in the way.
    fn least_gap_m(&self, wanted: &Twist, from: &[MovingDisc]) -> Option<f64> {
        let (mut pose, mut twist) = (self.now.pose, self.now.twist);
        let mut least_m = f64::INFINITY;
        for step in 1..=(LOOKS_AHEAD_S / STEP_S) as u32 {
            let before = twist;
            (pose, twist) = self.limits.advance(&pose, &twist, wanted, STEP_S);
            let moves = before != Twist::STOP || twist != Twist::STOP;
            if moves && !self.kept.keeps_off_what_stands(self.field, &pose) {
                return None;
            }
            let gap_m = |disc: &MovingDisc| {
                let center = disc.center();
                self.footprint.gap_to_disc_m(&pose, &center, disc.radius)
            };
            for disc in from {
                least_m = least_m.min(gap_m(&disc.after(f64::from(step) * STEP_S)));
                // He may have stopped or turned where he is: nobody is driven at because he is believed to move on.
                if moves && self.caution {
                    least_m = least_m.min(gap_m(disc));
                }
            }
        }
        Some(least_m)
    }
}
