//! What the local planner must keep apart: the footprint and the moving obstacles, with their margins.

use super::planning::local_margin_m;
use super::{NavigatorSettings, Observation};
use crate::geometry::Pose;
use crate::local::ClearanceField;
use crate::map::MovingDisc;
use crate::robot::{Disc, Footprint};

/// Footprint and moving obstacles, grown so that touching in the planner's eyes leaves the margins in truth.
///
/// A robot that already stands within a margin, because something came to it, keeps the distance it has: it can leave,
/// but not come closer.
pub(super) struct KeptClear {
    pub footprint: Footprint,
    pub moving: Vec<MovingDisc>,
}

/// The planner's own footprint grows no closer than this to what it must leave, metres.
const SLACK_M: f64 = 0.002;

impl KeptClear {
    pub fn new(
        footprint: &Footprint,
        settings: &NavigatorSettings,
        field: &ClearanceField,
        observation: &Observation,
    ) -> Self {
        let wall_m = field.clearance_m(footprint, &observation.pose).unwrap_or(0.0);
        let wanted_m = local_margin_m(settings, field.frame().resolution_m);
        let margin_m = wanted_m.min(wall_m - SLACK_M).max(0.0);
        let grown = |disc: &MovingDisc| {
            let gap_m = gap_m(footprint, &observation.pose, disc);
            let apart_m = settings.moving_margin_m.min(gap_m - SLACK_M).max(0.0);
            // The footprint's own margin counts towards the gap.
            MovingDisc { radius: (disc.radius + apart_m - margin_m).max(SLACK_M), ..*disc }
        };
        Self {
            footprint: footprint.padded(margin_m),
            moving: observation.moving.iter().map(grown).collect(),
        }
    }

    /// Whether the robot can turn on the spot: the circle that its discs sweep is clear.
    pub fn may_turn(&self, field: &ClearanceField, pose: &Pose) -> bool {
        let radius = self.footprint.circumscribed_radius_m();
        let Ok(swept) = Footprint::new(vec![Disc { x: 0.0, y: 0.0, radius }]) else {
            return false;
        };
        field.clearance_m(&swept, pose).is_some_and(|clearance| clearance > 0.0)
            && self.moving.iter().all(|disc| gap_m(&swept, pose, disc) > 0.0)
    }
}

/// Gap between a footprint and a moving obstacle, metres.
fn gap_m(footprint: &Footprint, pose: &Pose, disc: &MovingDisc) -> f64 {
    footprint
        .at(pose)
        .map(|(center, radius)| (disc.center() - center).norm() - radius - disc.radius)
        .fold(f64::INFINITY, f64::min)
}
