//! Passages in which a robot fits along its path, and cannot turn on the spot.

use super::NavigatorSettings;
use super::obstacle_model::FIELD_CELL_M;
use crate::geometry::Point;
use crate::map::{FreeSpace, MovingDisc, ObstacleGrid};
use crate::robot::{Disc, Footprint};

/// What a path keeps for the lookup of clearances, in cells: the local planner finds up to a cell too little clearance between two
/// walls along the grid, and the cells of a path are clear as a whole.
const LOOKUP_CELLS: f64 = 0.5;
/// The search is of use for a body that is narrower than its circumscribed circle by this, metres.
const LEAST_GAIN_M: f64 = 0.02;

/// The body of a robot in a narrow passage: the discs of the local planner, all as large as the largest.
#[derive(Clone, Debug)]
pub(super) struct NarrowPassages {
    /// Centres of the discs in the robot's frame, metres.
    pub discs: Vec<Point>,
    /// Distance that each of them keeps from obstacles, metres.
    radius_m: f64,
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
        let margin_m = settings.safety_margin_m + LOOKUP_CELLS * resolution_m.min(FIELD_CELL_M);
        let radius_m = footprint.max_disc_radius_m() + margin_m;
        let center = |disc: &Disc| Point::new(disc.x, disc.y);
        let discs = footprint.discs().iter().map(center).collect();
        (settings.features.narrow_passages && radius_m + LEAST_GAIN_M < least_radius_m)
            .then_some(Self { discs, radius_m, least_radius_m })
    }

    /// The cells in which a disc keeps its distance from obstacles, and the usual one from those that may not stay.
    pub fn space(&self, obstacles: &ObstacleGrid, transient: &[MovingDisc]) -> FreeSpace {
        let mut space = FreeSpace::new(obstacles, self.radius_m);
        if !transient.is_empty() {
            let frame = *obstacles.frame();
            let mut passing = ObstacleGrid::new(frame, vec![false; frame.len()]);
            for disc in transient {
                passing.fill_disc(&disc.center(), disc.radius);
            }
            space.intersect(&FreeSpace::new(&passing, self.least_radius_m));
        }
        space
    }
}
