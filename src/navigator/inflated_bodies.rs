//! Footprint and moving obstacles with their margins, for the local planner.

use super::NavigatorSettings;
use super::route_planner::{coarseness_m, local_margin_m};
use super::state::PredictedState;
use crate::geometry::Pose;
use crate::local::ClearanceField;
use crate::map::MovingDisc;
use crate::robot::Footprint;

/// A robot within a margin keeps this much less than its present distance, metres, so that standing is admissible.
const SLACK_M: f64 = 0.002;
/// The robot overshoots a margin by less than this, metres. An obstacle deeper within the margin came there by itself.
const OVERSHOOT_M: f64 = 0.03;
/// The robot always keeps this share of the margin for the map's resolution.
const MIN_RESOLUTION_SHARE: f64 = 0.5;
/// The robot always keeps this distance to moving obstacles, metres.
const MIN_MOVING_MARGIN_M: f64 = 0.05;

/// Footprint and moving obstacles, inflated: bodies that just touch in the planner are a margin apart in reality.
pub(super) struct InflatedBodies {
    pub footprint: Footprint,
    pub moving: Vec<MovingDisc>,
    /// Whether an obstacle is within its margin: the robot then drives slowly.
    pub within_a_margin: bool,
    /// Padding of the footprint, metres.
    margin_m: f64,
}

impl InflatedBodies {
    /// Inflates by the whole margins, or by a part of a margin that an obstacle is within. Otherwise no velocity would be
    /// admissible next to a person who came close and stopped, not even one that leads away.
    pub fn new(
        footprint: &Footprint,
        settings: &NavigatorSettings,
        field: &ClearanceField,
        now: &PredictedState,
    ) -> Self {
        let pose = &now.pose;
        let resolution_m = field.frame().resolution_m;
        let wanted_m = local_margin_m(settings, resolution_m);
        let static_m = field.clearance_m(footprint, pose).unwrap_or(0.0);
        let mut within_a_margin = static_m < wanted_m - OVERSHOOT_M;
        let margin_m = if within_a_margin {
            let least_m = MIN_RESOLUTION_SHARE * coarseness_m(resolution_m);
            reduced_margin_m(wanted_m, static_m, least_m)
        } else {
            wanted_m
        };
        let inflate = |disc: &MovingDisc| {
            let gap_m = footprint.gap_to_moving_m(pose, disc);
            let came_close = gap_m < settings.moving_margin_m - OVERSHOOT_M;
            within_a_margin |= came_close;
            let kept_m = if came_close {
                reduced_margin_m(settings.passing_margin_m, gap_m, MIN_MOVING_MARGIN_M)
            } else {
                settings.moving_margin_m
            };
            // The footprint's own padding counts towards the gap.
            MovingDisc { radius: (disc.radius + (kept_m - margin_m)).max(SLACK_M), ..*disc }
        };
        Self {
            moving: now.moving.iter().map(inflate).collect(),
            footprint: footprint.padded(margin_m),
            within_a_margin,
            margin_m,
        }
    }

    /// Whether a robot at a pose, this many seconds from now, touches nothing.
    pub fn is_clear_at(&self, field: &ClearanceField, pose: &Pose, time_s: f64) -> bool {
        let clearance_m = field.clearance_m(&self.footprint, pose);
        clearance_m.is_some_and(|clearance_m| clearance_m > 0.0)
            && self.is_clear_of_moving(pose, time_s)
    }

    /// Whether a robot at a pose certainly touches no static obstacle, whatever the map's resolution hides.
    pub fn is_clear_of_static(&self, field: &ClearanceField, pose: &Pose) -> bool {
        let inflated_m = field.clearance_m(&self.footprint, pose);
        let coarseness_m = coarseness_m(field.frame().resolution_m);
        inflated_m.is_some_and(|inflated_m| inflated_m + self.margin_m >= coarseness_m)
    }

    /// Whether a robot at a pose, this many seconds from now, touches no moving obstacle.
    pub fn is_clear_of_moving(&self, pose: &Pose, time_s: f64) -> bool {
        let gap_m = |disc: &MovingDisc| self.footprint.gap_to_moving_m(pose, &disc.after(time_s));
        self.moving.iter().all(|disc| gap_m(disc) > 0.0)
    }
}

/// A margin, or what is left of it at a distance, but never below the least value: else the robot could come nearer by the
/// slack at each tick until it touches.
fn reduced_margin_m(margin_m: f64, distance_m: f64, least_m: f64) -> f64 {
    margin_m.min((distance_m - SLACK_M).max(least_m))
}
