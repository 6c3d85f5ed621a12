//! Everything about the robot that its map does not show: marks of what stands, discs that move.

use std::sync::Arc;

use super::local_map::LocalMap;
use super::tracker::Tracker;
use crate::geometry::{Point, Pose};
use crate::local::{ClearanceField, ProblemError};
use crate::map::{MovingDisc, ObstacleGrid, Scan};

/// A return this close to something moving is it, metres.
const MOVING_MARGIN_M: f64 = 0.12;
/// Marks that something moving made before it was seen to move are this much older than its track at most, seconds.
const BEFORE_TRACK_S: f64 = 0.05;

/// The local map and the tracker, fed by the same scans.
pub struct ObstacleModel {
    map: LocalMap,
    /// None where moving things are marks like all others.
    tracker: Option<Tracker>,
}

impl ObstacleModel {
    /// Nothing seen yet beyond the known obstacles.
    #[must_use]
    pub fn new(known: ObstacleGrid) -> Self {
        Self {
            map: LocalMap::new(known),
            tracker: Some(Tracker::default()),
        }
    }

    /// The same that tells nothing that moves from what stands.
    #[must_use]
    pub fn without_tracking(known: ObstacleGrid) -> Self {
        Self {
            tracker: None,
            ..Self::new(known)
        }
    }

    /// Takes in a scan made at a time, seconds, from a pose in the map frame: follows what moves, marks the rest, and
    /// clears marks that the scan saw through. The scan must be sound ([`Scan::is_valid`]), pose and time finite.
    pub fn update(&mut self, time_s: f64, pose: &Pose, scan: &Scan) {
        let Some(tracker) = &mut self.tracker else {
            self.map.clear_seen_through(pose, scan);
            for hit in scan.hits(pose) {
                self.map.mark(time_s, &hit);
            }
            return;
        };
        let map = &self.map;
        tracker.update(time_s, pose, scan, |point| map.known_at(time_s, point));
        for (disc, since_s) in tracker.places_moved_over() {
            self.map
                .erase(&disc, MOVING_MARGIN_M, since_s - BEFORE_TRACK_S);
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

    /// What moves, or moved until a moment ago, in the map frame at the time of the last scan.
    #[must_use]
    pub fn moving(&self) -> &[MovingDisc] {
        self.tracker.as_ref().map_or(&[], Tracker::moving)
    }

    /// Forgets marks that no scan hit since a time, seconds, but for those within a distance of a place, metres: for a robot
    /// that they leave no way.
    pub(super) fn forget(&mut self, since_s: f64, place: &Point, near_m: f64) {
        self.map.forget(since_s, place, near_m);
    }

    /// Centres of the marked cells.
    pub fn marks(&self) -> impl Iterator<Item = Point> + '_ {
        self.map.marks()
    }

    /// The distance field of a square window about a point, `half_m` to each side, aligned with the map's cells. Ground
    /// off the map is an obstacle.
    ///
    /// # Errors
    /// When the map's resolution is out of range, or the window has more than 4095 cells a side.
    pub fn window(&self, center: &Point, half_m: f64) -> Result<Arc<ClearanceField>, ProblemError> {
        self.map.window(center, half_m)
    }
}
