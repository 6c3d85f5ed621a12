//! What the local planner must keep apart: the footprint and the moving obstacles, with their margins.

use super::planning::local_margin_m;
use super::{NavigatorSettings, Observation};
use crate::geometry::Pose;
use crate::local::ClearanceField;
use crate::map::MovingDisc;
use crate::robot::{Disc, Footprint};

/// Footprint and moving obstacles, grown so that touching in the planner's eyes leaves the margins in truth.
pub(super) struct KeptClear {
    pub footprint: Footprint,
    pub moving: Vec<MovingDisc>,
    /// Whether something is within its margin: a reason to go slowly.
    pub within_a_margin: bool,
}

/// A robot within a margin keeps this much less than the distance it has, metres, so that standing is admissible.
const SLACK_M: f64 = 0.002;
/// The robot itself overshoots a margin by less than this, metres; whoever is deeper within it came there.
const OVERSHOOT_M: f64 = 0.03;

impl KeptClear {
    /// The whole margins; but where something is within one, only a part: else nothing would be admissible beside a
    /// person who came close and stopped, not even driving on.
    pub fn new(
        footprint: &Footprint,
        settings: &NavigatorSettings,
        field: &ClearanceField,
        observation: &Observation,
    ) -> Self {
        let deep_m = settings.moving_margin_m - OVERSHOOT_M;
        let moving = &observation.moving;
        Self::with_less_within(
            deep_m,
            footprint,
            settings,
            field,
            &observation.pose,
            moving,
        )
    }

    /// For a robot that gets away from where it is: of everybody only the passing margin, and whoever is within the
    /// whole one counts as standing. Were they taken to walk on into the robot, no way out would be admissible.
    pub fn to_get_away(
        footprint: &Footprint,
        settings: &NavigatorSettings,
        field: &ClearanceField,
        observation: &Observation,
    ) -> Self {
        let pose = &observation.pose;
        let calmed = |disc: &MovingDisc| {
            if gap_m(footprint, pose, disc) < settings.moving_margin_m {
                let (vx, vy) = (0.0, 0.0);
                MovingDisc { vx, vy, ..*disc }
            } else {
                *disc
            }
        };
        let moving: Vec<MovingDisc> = observation.moving.iter().map(calmed).collect();
        Self::with_less_within(f64::INFINITY, footprint, settings, field, pose, &moving)
    }

    /// Keeps only the passing margin to whoever is nearer than `deep_m`.
    fn with_less_within(
        deep_m: f64,
        footprint: &Footprint,
        settings: &NavigatorSettings,
        field: &ClearanceField,
        pose: &Pose,
        moving: &[MovingDisc],
    ) -> Self {
        let wanted_m = local_margin_m(settings, field.frame().resolution_m);
        let wall_m = field.clearance_m(footprint, pose).unwrap_or(0.0);
        let margin_m = if wall_m < wanted_m - OVERSHOOT_M || deep_m.is_infinite() {
            wanted_m.min(wall_m - SLACK_M).max(0.0)
        } else {
            wanted_m
        };
        let mut within_a_margin = margin_m < wanted_m;
        let grow = |disc: &MovingDisc| {
            let gap_m = gap_m(footprint, pose, disc);
            within_a_margin |= gap_m < deep_m;
            let kept_m = if gap_m < deep_m {
                settings.passing_margin_m.min(gap_m - SLACK_M).max(0.0)
            } else {
                settings.moving_margin_m
            };
            grown(disc, kept_m - margin_m)
        };
        Self {
            moving: moving.iter().map(grow).collect(),
            footprint: footprint.padded(margin_m),
            within_a_margin,
        }
    }

    /// Whether the robot can turn on the spot: the circle that its discs sweep is clear.
    pub fn may_turn(&self, field: &ClearanceField, pose: &Pose) -> bool {
        let radius = self.footprint.circumscribed_radius_m();
        let Ok(swept) = Footprint::new(vec![Disc {
            x: 0.0,
            y: 0.0,
            radius,
        }]) else {
            return false;
        };
        field
            .clearance_m(&swept, pose)
            .is_some_and(|clearance| clearance > 0.0)
            && self
                .moving
                .iter()
                .all(|disc| gap_m(&swept, pose, disc) > 0.0)
    }
}

/// A moving obstacle with a margin beyond the footprint's own, which counts towards the gap.
fn grown(disc: &MovingDisc, margin_m: f64) -> MovingDisc {
    MovingDisc {
        radius: (disc.radius + margin_m).max(SLACK_M),
        ..*disc
    }
}

/// Gap between a footprint and a moving obstacle, metres.
fn gap_m(footprint: &Footprint, pose: &Pose, disc: &MovingDisc) -> f64 {
    footprint
        .at(pose)
        .map(|(center, radius)| (disc.center() - center).norm() - radius - disc.radius)
        .fold(f64::INFINITY, f64::min)
}
