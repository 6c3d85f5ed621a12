//! Passages in which a robot fits along its path, and cannot turn on the spot.

use super::NavigatorSettings;
use super::obstacle_model::NARROW_FIELD_CELL_M;
use crate::geometry::Point;
use crate::map::{FreeSpace, MovingDisc, ObstacleGrid};
use crate::robot::{Disc, Footprint};

/// What a path keeps for the lookup of clearances, in cells of the local window: the local planner finds up to a cell too little
/// clearance between two walls along the grid.
const LOOKUP_CELLS: f64 = 1.0;
/// In a narrow passage the local planner checks poses so near to each other that it overlooks at most this between them, metres.
pub(super) const OVERLOOKED_M: f64 = 0.005;
/// The search runs only for a body that is narrower than its circumscribed circle by at least this, metres.
const LEAST_GAIN_M: f64 = 0.02;

/// The body of a robot in a narrow passage: a row of discs, all as large as the largest.
#[derive(Clone, Debug)]
pub(super) struct NarrowPassages {
    /// Centres of the discs in the robot's frame, metres.
    pub discs: Vec<Point>,
    /// Distance that each of them keeps from obstacles, metres.
    pub radius_m: f64,
    /// Distance that the robot keeps from obstacles elsewhere, metres.
    least_radius_m: f64,
}

impl NarrowPassages {
    /// `None` for a robot that keeps about this distance, metres, in a narrow passage too.
    pub fn new(
        footprint: &Footprint,
        settings: &NavigatorSettings,
        resolution_m: f64,
        least_radius_m: f64,
    ) -> Option<Self> {
        let footprint = footprint.slim();
        let margin_m =
            settings.safety_margin_m + LOOKUP_CELLS * resolution_m.min(NARROW_FIELD_CELL_M);
        let radius_m = footprint.max_disc_radius_m() + margin_m;
        let center = |disc: &Disc| Point::new(disc.x, disc.y);
        let discs = footprint.discs().iter().map(center).collect();
        (settings.features.narrow_passages && radius_m + LEAST_GAIN_M < least_radius_m)
            .then_some(Self { discs, radius_m, least_radius_m })
    }

    /// The cells in which a disc keeps its distance from obstacles wherever it is, and those in which it keeps it at the centre. It
    /// keeps the usual distance from what may not stay.
    pub fn spaces(&self, obstacles: &ObstacleGrid, transient: &[MovingDisc]) -> [FreeSpace; 2] {
        // The centre of a cell is half a cell farther from an obstacle than its sides.
        let at_center_m = self.radius_m - 0.5 * obstacles.frame().resolution_m;
        let mut spaces = FreeSpace::for_radii(obstacles, [self.radius_m, at_center_m]);
        if !transient.is_empty() {
            let frame = *obstacles.frame();
            let mut passing = ObstacleGrid::filled(frame, false);
            for disc in transient {
                passing.fill_disc(&disc.center(), disc.radius);
            }
            let apart = FreeSpace::new(&passing, self.least_radius_m);
            spaces.iter_mut().for_each(|space| space.intersect(&apart));
        }
        spaces
    }
}
