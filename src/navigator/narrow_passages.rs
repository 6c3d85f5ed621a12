//! Passages in which a robot fits along its path, and cannot turn on the spot.

use core::f64::consts::SQRT_2;

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
        let discs = centers_of_equal_discs(footprint.discs(), footprint.max_disc_radius_m());
        (settings.features.narrow_passages && radius_m + LEAST_GAIN_M < least_radius_m)
            .then_some(Self { discs, radius_m, least_radius_m })
    }

    /// The cells in which a disc keeps its distance from obstacles wherever it is, those in which it keeps it at the centre, and those
    /// in which it may keep it at some place. It keeps the usual distance from what may not stay.
    pub fn spaces(&self, obstacles: &ObstacleGrid, transient: &[MovingDisc]) -> [FreeSpace; 3] {
        // The centre of a cell is half a cell farther from an obstacle than its sides, and a corner at most a diagonal farther.
        let cell_m = obstacles.frame().resolution_m;
        let radii_m = [0.0, 0.5, SQRT_2].map(|cells| self.radius_m - cells * cell_m);
        let mut spaces = FreeSpace::for_radii(obstacles, radii_m);
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

/// Centres of discs of this radius, metres, that contain given discs of at most this radius. A smaller disc at one side gives a larger
/// one nearer to the middle, so that this stands out to the side as little as possible.
fn centers_of_equal_discs(discs: &[Disc], radius_m: f64) -> Vec<Point> {
    let side_m = |sign: f64| {
        let reach = |disc: &Disc| sign * disc.y + disc.radius;
        sign * discs.iter().map(reach).fold(f64::NEG_INFINITY, f64::max)
    };
    let middle = 0.5 * (side_m(1.0) + side_m(-1.0));
    let center = |disc: &Disc| {
        let (aside, room_m) = (disc.y - middle, radius_m - disc.radius);
        Point::new(disc.x, disc.y - aside.clamp(-room_m, room_m))
    };
    discs.iter().map(center).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::Polygon;

    fn passages(corners: &[(f64, f64)]) -> NarrowPassages {
        let corners = corners.iter().map(|&(x, y)| Point::new(x, y)).collect();
        let footprint = Footprint::covering(Polygon::new(corners).expect("a polygon"));
        NarrowPassages::new(&footprint, &NavigatorSettings::default(), 0.05, 1.0).expect("slim")
    }

    /// A robot inside another one passes wherever the other one passes.
    #[test]
    fn body_without_a_corner_needs_no_more_room_to_its_sides_than_with_it() {
        let side_m = |passages: &NarrowPassages| {
            let aside_m = passages.discs.iter().map(|center| center.y.abs()).fold(0.0, f64::max);
            aside_m + passages.radius_m
        };
        let whole =
            side_m(&passages(&[(0.35, 0.25), (0.35, -0.25), (-0.35, -0.25), (-0.35, 0.25)]));
        // The front right corner is cut off along two lines, along one, and along one that leaves a thin front.
        for front in [
            &[(0.35, 0.25), (0.35, 0.15), (0.1, 0.15), (0.1, -0.25)][..],
            &[(0.35, 0.25), (0.35, 0.0), (0.1, -0.25)],
            &[(0.35, 0.25), (0.35, 0.2), (-0.2, -0.25)],
        ] {
            let corners = [front, &[(-0.35, -0.25), (-0.35, 0.25)]].concat();
            let cut = side_m(&passages(&corners));
            assert!(cut <= whole + 1e-4, "{corners:?}: {cut} m, not {whole} m");
        }
    }
}
