//! Obstacles that are not in the map: marked cells where they are static, discs where they move.

use std::sync::Arc;

use super::local_map::LocalMap;
use super::tracker::Tracker;
use crate::geometry::{Point, Pose};
use crate::local::{ClearanceField, ProblemError};
use crate::map::{MovingDisc, ObstacleGrid, Scan};

/// A return within this distance of a moving obstacle belongs to it, metres.
const MOVING_MARGIN_M: f64 = 0.12;
/// Marks that a moving obstacle made before its motion was established are at most this much older than its track, seconds.
const BEFORE_TRACK_S: f64 = 0.05;

/// Obstacles that the lidar saw and the map does not show.
pub struct ObstacleModel {
    map: LocalMap,
    /// Nothing where moving obstacles are marked as static ones.
    tracker: Option<Tracker>,
}

impl ObstacleModel {
    /// A model over the known obstacles, without any others.
    #[must_use]
    pub fn new(known: ObstacleGrid) -> Self {
        Self { map: LocalMap::new(known), tracker: Some(Tracker::default()) }
    }

    /// As [`Self::new`], but without tracking: every obstacle counts as static.
    #[must_use]
    pub fn without_tracking(known: ObstacleGrid) -> Self {
        Self { tracker: None, ..Self::new(known) }
    }

    /// Updates the model with a scan made at a time, seconds, from a pose in the map frame: tracks moving obstacles, marks the
    /// other returns, and clears marks that the scan saw through. The scan must be valid ([`Scan::is_valid`]), pose and time
    /// finite.
    pub fn update(&mut self, time_s: f64, pose: &Pose, scan: &Scan) {
        let Some(tracker) = &mut self.tracker else {
            self.map.clear_seen_through(pose, scan);
            for hit in scan.hits(pose) {
                self.map.mark(time_s, &hit);
            }
            return;
        };
        let map = &self.map;
        tracker.update(time_s, pose, scan, |point| map.origin_at(time_s, point));
        for (disc, since_s) in tracker.swept_discs() {
            self.map.erase(&disc, MOVING_MARGIN_M, since_s - BEFORE_TRACK_S);
        }
        self.map.clear_seen_through(pose, scan);
        let moving = tracker.moving();
        for point in tracker.points() {
            let is_moving = moving
                .iter()
                .any(|disc| (disc.center() - point).norm() <= disc.radius + MOVING_MARGIN_M);
            if !is_moving {
                self.map.mark(time_s, &point);
            }
        }
    }

    /// Obstacles that move, or moved until a moment ago, in the map frame at the time of the last scan.
    #[must_use]
    pub fn moving(&self) -> &[MovingDisc] {
        self.tracker.as_ref().map_or(&[], Tracker::moving)
    }

    /// Forgets marks that no scan hit since a time, seconds, except those within a distance of a place, metres: for a robot
    /// that has no path among them.
    pub(super) fn forget(&mut self, since_s: f64, place: &Point, near_m: f64) {
        self.map.forget(since_s, place, near_m);
    }

    /// Centres of the marked cells.
    pub fn marks(&self) -> impl Iterator<Item = Point> + '_ {
        self.map.marks()
    }

    /// The distance field of a square window around a point, `half_m` to each side, aligned with the map's cells. Cells
    /// outside the map are obstacles.
    ///
    /// # Errors
    /// When the map's resolution is out of range, or the window has more than 4095 cells a side.
    pub fn window(&self, center: &Point, half_m: f64) -> Result<Arc<ClearanceField>, ProblemError> {
        self.map.window(center, half_m)
    }
}
