//! What the local planner must keep apart: the footprint and the moving obstacles, with their margins.

use super::NavigatorSettings;
use super::predicted_state::PredictedState;
use super::route_planner::{coarseness_m, local_margin_m};
use crate::geometry::Pose;
use crate::local::ClearanceField;
use crate::map::MovingDisc;
use crate::robot::Footprint;

/// Footprint and moving obstacles, grown so that touching in the planner's eyes leaves the margins in truth.
pub(super) struct InflatedBodies {
    pub footprint: Footprint,
    pub moving: Vec<MovingDisc>,
    /// Whether something is within its margin: a reason to go slowly.
    pub within_a_margin: bool,
    /// What the footprint has grown by, metres.
    margin_m: f64,
}

/// A robot within a margin keeps this much less than the distance it has, metres, so that standing is admissible.
const SLACK_M: f64 = 0.002;
/// The robot itself overshoots a margin by less than this, metres; whoever is deeper within it came there.
const OVERSHOOT_M: f64 = 0.03;

/// However close it is, it keeps this share of what the map's coarseness demands.
const DRIVING_SHARE: f64 = 0.5;
/// And this from people, metres.
const LEAST_TO_PEOPLE_M: f64 = 0.05;

impl InflatedBodies {
    /// The whole margins; but where something is within one, only a part: else nothing would be admissible beside a
    /// person who came close and stopped, not even driving on.
    pub fn new(
        footprint: &Footprint,
        settings: &NavigatorSettings,
        field: &ClearanceField,
        now: &PredictedState,
    ) -> Self {
        let pose = &now.pose;
        let wanted_m = local_margin_m(settings, field.frame().resolution_m);
        let wall_m = field.clearance_m(footprint, pose).unwrap_or(0.0);
        let mut within_a_margin = wall_m < wanted_m - OVERSHOOT_M;
        let margin_m = if within_a_margin {
            left_of(
                wanted_m,
                wall_m,
                DRIVING_SHARE * coarseness_m(field.frame().resolution_m),
            )
        } else {
            wanted_m
        };
        let grow = |disc: &MovingDisc| {
            let gap_m = footprint.gap_to_disc_m(pose, &disc.center(), disc.radius);
            let came_close = gap_m < settings.moving_margin_m - OVERSHOOT_M;
            within_a_margin |= came_close;
            let kept_m = if came_close {
                left_of(settings.passing_margin_m, gap_m, LEAST_TO_PEOPLE_M)
            } else {
                settings.moving_margin_m
            };
            grown(disc, kept_m - margin_m)
        };
        Self {
            moving: now.moving.iter().map(grow).collect(),
            footprint: footprint.padded(margin_m),
            within_a_margin,
            margin_m,
        }
    }

    /// Whether a robot at a pose, so many seconds from now, would touch nothing.
    pub fn is_clear_at(&self, field: &ClearanceField, pose: &Pose, time_s: f64) -> bool {
        let clearance_m = field.clearance_m(&self.footprint, pose);
        clearance_m.is_some_and(|clearance_m| clearance_m > 0.0)
            && self.is_clear_of_moving(pose, time_s)
    }

    /// Whether the robot at a pose is certain not to touch anything that stands, however coarse the map.
    pub fn keeps_off_what_stands(&self, field: &ClearanceField, pose: &Pose) -> bool {
        let body_m = field.clearance_m(&self.footprint, pose);
        let coarseness_m = coarseness_m(field.frame().resolution_m);
        body_m.is_some_and(|grown_m| grown_m + self.margin_m >= coarseness_m)
    }

    /// Whether everybody keeps clear of a robot at a pose, so many seconds from now.
    pub fn is_clear_of_moving(&self, pose: &Pose, time_s: f64) -> bool {
        self.moving.iter().all(|disc| {
            let then = disc.after(time_s);
            let gap_m = self
                .footprint
                .gap_to_disc_m(pose, &then.center(), then.radius);
            gap_m > 0.0
        })
    }
}

/// A margin, or what is left of it at a distance, but not less than the least: or a robot within it could come nearer by
/// the slack at each tick, until it touches.
fn left_of(margin_m: f64, distance_m: f64, least_m: f64) -> f64 {
    margin_m.min((distance_m - SLACK_M).max(least_m))
}

/// A moving obstacle with a margin beyond the footprint's own, which counts towards the gap.
fn grown(disc: &MovingDisc, margin_m: f64) -> MovingDisc {
    MovingDisc {
        radius: (disc.radius + margin_m).max(SLACK_M),
        ..*disc
    }
}
