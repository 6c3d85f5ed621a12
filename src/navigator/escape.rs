//! Out of where nothing goes on: slowly, away from what is near, back to where the robot came from.
//!
//! The dynamic window asks that a robot could stop within its clearance; beside a wall there is none, and it could only
//! creep (eq. 30). Here it is enough not to come nearer than it is already, by the exact gap to every cell close by.

use super::exact_clearance::ExactClearance;
use super::navigator::{Decision, Navigator};
use super::predicted_state::PredictedState;
use super::{Mode, NavigatorSettings};
use crate::geometry::{Point, Pose, Twist};
use crate::local::ClearanceField;
use crate::map::MovingDisc;
use crate::robot::{Footprint, Limits};

/// A way out is looked over for so long, seconds, in such steps.
const LOOKS_AHEAD_S: f64 = 1.5;
const STEP_S: f64 = 0.1;
/// What stands within this of the robot's circle is looked at, metres.
const SEEN_M: f64 = 0.5;
/// Nothing is approached to less than this, metres; what is nearer already is not approached at all.
const LEAST_GAP_M: f64 = 0.04;
/// People are left this much, metres.
const LEAST_TO_PEOPLE_M: f64 = 0.1;
/// More room than this is not sought, metres.
const ENOUGH_GAP_M: f64 = 0.25;
/// A metre nearer to where it came from is worth so much room.
const WAY_BACK: f64 = 0.3;
/// Shares of the backing speed, and turn rates in rad/s, that are tried.
const SPEEDS: [f64; 5] = [-1.0, -0.5, 0.0, 0.5, 1.0];
const TURN_RATES: [f64; 7] = [0.0, 0.2, -0.2, 0.4, -0.4, 0.8, -0.8];

/// What a way out must keep clear of.
struct Surface<'a> {
    footprint: &'a Footprint,
    exact_clearance: ExactClearance,
    people: &'a [MovingDisc],
}

impl Surface<'_> {
    fn gap_m(&self, pose: &Pose) -> f64 {
        self.exact_clearance.gap_m(self.footprint, pose)
    }

    fn gap_to_people_m(&self, pose: &Pose) -> f64 {
        let gap = |disc: &MovingDisc| {
            let center = disc.center();
            self.footprint.gap_to_disc_m(pose, &center, disc.radius)
        };
        self.people.iter().map(gap).fold(f64::INFINITY, f64::min)
    }
}

impl Navigator {
    /// The slow motion that leads to the most room, and back to where the robot came from; it stands where none does.
    pub(super) fn get_out(
        &mut self,
        now: &PredictedState,
        field: &ClearanceField,
        target: Point,
    ) -> Decision {
        let footprint = &self.robot.footprint;
        let reach_m = footprint.circumscribed_radius_m() + SEEN_M;
        let surface = Surface {
            footprint,
            exact_clearance: ExactClearance::new(field, &now.pose.position(), reach_m),
            people: &now.moving,
        };
        let behind = self.recovery.place_behind(&now.pose);
        let wanted = best_way(
            now,
            &surface,
            &behind,
            (&self.settings, &self.robot.limits),
            |wanted| self.is_safe_towards(now, wanted),
        );
        self.mode = Mode::Escaping;
        Decision {
            command: self.towards(now, &wanted),
            local_target: target,
            ..self.stand(now, Mode::Escaping)
        }
    }
}

fn best_way(
    now: &PredictedState,
    surface: &Surface<'_>,
    behind: &Point,
    (settings, limits): (&NavigatorSettings, &Limits),
    is_safe: impl Fn(&Twist) -> bool,
) -> Twist {
    let mut best = (f64::NEG_INFINITY, Twist::STOP);
    for share in SPEEDS {
        for rate in TURN_RATES {
            let wanted = limits.clamp(&Twist::new(share * settings.escape_speed, rate));
            let Some(end) = end_of(now, &wanted, surface, limits) else {
                continue;
            };
            let room_m = surface.gap_m(&end).min(ENOUGH_GAP_M);
            let score = room_m - WAY_BACK * (behind - end.position()).norm();
            if score > best.0 && is_safe(&wanted) {
                best = (score, wanted);
            }
        }
    }
    best.1
}

/// Where a way ends that comes too near to nothing.
fn end_of(
    now: &PredictedState,
    wanted: &Twist,
    surface: &Surface<'_>,
    limits: &Limits,
) -> Option<Pose> {
    let (mut pose, mut twist) = (now.pose, now.twist);
    let least_m = surface.gap_m(&pose).min(LEAST_GAP_M);
    let least_to_people_m = surface.gap_to_people_m(&pose).min(LEAST_TO_PEOPLE_M);
    for _ in 0..(LOOKS_AHEAD_S / STEP_S) as u32 {
        (pose, twist) = limits.advance(&pose, &twist, wanted, STEP_S);
        if surface.gap_m(&pose) < least_m || surface.gap_to_people_m(&pose) < least_to_people_m {
            return None;
        }
    }
    Some(pose)
}
