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
}

/// A robot within a margin keeps this much less than the distance it has, metres, so that standing is admissible.
const SLACK_M: f64 = 0.002;

impl KeptClear {
    /// The whole margins.
    pub fn new(
        footprint: &Footprint,
        settings: &NavigatorSettings,
        resolution_m: f64,
        observation: &Observation,
    ) -> Self {
        let margin_m = local_margin_m(settings, resolution_m);
        let grow = |disc: &MovingDisc| grown(disc, settings.moving_margin_m - margin_m);
        Self {
            footprint: footprint.padded(margin_m),
            moving: observation.moving.iter().map(grow).collect(),
        }
    }

    /// What is left of the margins for a robot that stands within them, because something came to it: it can leave, but
    /// not come closer.
    pub fn what_is_left(
        footprint: &Footprint,
        settings: &NavigatorSettings,
        field: &ClearanceField,
        observation: &Observation,
    ) -> Self {
        let pose = &observation.pose;
        let wall_m = field.clearance_m(footprint, pose).unwrap_or(0.0);
        let wanted_m = local_margin_m(settings, field.frame().resolution_m);
        let margin_m = wanted_m.min(wall_m - SLACK_M).max(0.0);
        let grow = |disc: &MovingDisc| {
            let gap_m = gap_m(footprint, pose, disc);
            grown(
                disc,
                settings.moving_margin_m.min(gap_m - SLACK_M).max(0.0) - margin_m,
            )
        };
        Self {
            footprint: footprint.padded(margin_m),
            moving: observation.moving.iter().map(grow).collect(),
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
