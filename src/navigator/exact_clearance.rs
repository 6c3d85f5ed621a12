//! Exact distances to the occupied cells near the robot.
//!
//! The distance field has one distance for all points of a cell: it is good to a cell's diagonal. The clearance of a robot
//! that leaves a corner is smaller.

use crate::geometry::{Point, Pose, Vector, point_to_unit_square};
use crate::local::ClearanceField;
use crate::map::{Cell, GridFrame};
use crate::robot::{Footprint, Polygon};

/// The occupied cells around a place, as squares.
#[derive(Clone, Debug)]
pub(super) struct ExactClearance {
    frame: GridFrame,
    /// Lower left corners, in cells.
    squares: Vec<Point>,
    reach_m: f64,
}

impl ExactClearance {
    /// Collects the occupied cells of a field's window within a distance of a place.
    pub fn new(field: &ClearanceField, place: &Point, reach_m: f64) -> Self {
        let frame = *field.frame();
        let units = field.units();
        let squares = frame
            .cells_around(place, reach_m)
            .filter(|&cell| units[frame.index(cell)] == 0)
            .map(Cell::corner)
            .collect();
        Self { frame, squares, reach_m }
    }

    /// The gap between the body at a pose and the nearest occupied cell, metres: at or below zero they touch. At most the
    /// distance within which cells were collected.
    pub fn gap_m(&self, footprint: &Footprint, pose: &Pose) -> f64 {
        if let Some(body) = footprint.body() {
            return PlacedBody::new(body, pose, &self.frame)
                .gap(&self.squares, self.reach_m / self.frame.resolution_m)
                * self.frame.resolution_m;
        }
        let gap = |(center, radius_m): (Point, f64)| {
            let units = self.frame.to_cell_units(&center);
            let squared = |square: &Point| point_to_unit_square(&units, square);
            let nearest = self.squares.iter().map(squared).fold(f64::INFINITY, f64::min);
            nearest.sqrt() * self.frame.resolution_m - radius_m
        };
        footprint.at(pose).map(gap).fold(self.reach_m, f64::min)
    }

    /// Whether the gap is at least this, metres: at most the distance within which cells were collected.
    pub fn keeps_gap(&self, footprint: &Footprint, pose: &Pose, gap_m: f64) -> bool {
        let Some(body) = footprint.body() else {
            return self.gap_m(footprint, pose) >= gap_m;
        };
        let body = PlacedBody::new(body, pose, &self.frame);
        let resolution_m = self.frame.resolution_m;
        let within = gap_m / resolution_m;
        !self.squares.iter().any(|square| {
            body.may_be_within(square, within)
                && body.outline.distance_to_unit_square(square) * resolution_m < gap_m
        })
    }
}

/// Half of a cell's diagonal, rounded up, in cells.
const HALF_DIAGONAL: f64 = 0.7072;

/// A body at a pose, in cells, with the box around it in its own frame. The box tells which cells are too far to matter.
struct PlacedBody {
    outline: Polygon,
    origin: Point,
    sin: f64,
    cos: f64,
    middle: Vector,
    half: Vector,
}

impl PlacedBody {
    fn new(body: &Polygon, pose: &Pose, frame: &GridFrame) -> Self {
        let (low, high) = body.bounds();
        let (sin, cos) = libm::sincos(pose.yaw - frame.origin.yaw);
        let in_cells = |point: Point| point.to_vector() / frame.resolution_m;
        let (low, high) = (in_cells(low), in_cells(high));
        Self {
            outline: body.mapped(|corner| frame.to_cell_units(&pose.transform(corner))),
            origin: frame.to_cell_units(&pose.position()),
            sin,
            cos,
            middle: (low + high) / 2.0,
            half: (high - low) / 2.0,
        }
    }

    /// Squared distance between the middle of a square and the box.
    fn squared_to_box(&self, square: &Point) -> f64 {
        let (x, y) = (square.x + 0.5 - self.origin.x, square.y + 0.5 - self.origin.y);
        let beyond = |at: f64, middle: f64, half: f64| ((at - middle).abs() - half).max(0.0);
        let along = beyond(self.cos * x + self.sin * y, self.middle.x, self.half.x);
        let across = beyond(self.cos * y - self.sin * x, self.middle.y, self.half.y);
        along * along + across * across
    }

    /// Whether the distance to a square may be less than this.
    fn may_be_within(&self, square: &Point, distance: f64) -> bool {
        let reach = distance + HALF_DIAGONAL;
        self.squared_to_box(square) < reach * reach
    }

    /// The distance to the nearest square, at most this.
    fn gap(&self, squares: &[Point], most: f64) -> f64 {
        let to_box = |square: &&Point| self.squared_to_box(square);
        // The first one is probably the nearest, and rules most others out.
        let first = squares.iter().min_by(|one, other| to_box(one).total_cmp(&to_box(other)));
        let distance = |square: &Point| self.outline.distance_to_unit_square(square);
        first.into_iter().chain(squares).fold(most, |least, square| {
            if self.may_be_within(square, least) { least.min(distance(square)) } else { least }
        })
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    use super::*;
    use crate::map::ObstacleGrid;

    #[test]
    fn gap_is_the_distance_to_the_nearest_square() {
        let frame = GridFrame::new(40, 40, 0.1, Pose::new(1.0, 2.0, 0.3)).expect("a valid size");
        let mut obstacles = ObstacleGrid::filled(frame, false);
        obstacles.set(Cell::new(30, 20), true);
        let field = ClearanceField::new(&obstacles).expect("a valid resolution");
        let footprint = Footprint::round(0.3).expect("a valid radius");
        // In cells: 6.3 to the left of the square, level with it; then 0.4 left of and 0.5 below its corner.
        for (x, y, gap_m) in [(23.7, 20.5, 0.33), (29.6, 19.5, 0.064_031 - 0.3)] {
            let place = frame.from_cell_units(&Point::new(x, y));
            let clearance = ExactClearance::new(&field, &place, 1.0);
            let found_m = clearance.gap_m(&footprint, &Pose::new(place.x, place.y, 1.0));
            assert!((found_m - gap_m).abs() < 1e-6, "{found_m} at {x}, {y}");
        }
        let far = frame.from_cell_units(&Point::new(5.0, 5.0));
        let clearance = ExactClearance::new(&field, &far, 0.5);
        assert_eq!(clearance.gap_m(&footprint, &Pose::new(far.x, far.y, 0.0)), 0.5);
    }

    /// Against the distances to all squares, without the box.
    #[test]
    fn gap_of_a_polygon_is_that_to_all_squares_to_the_bit() {
        let mut random = Pcg64Mcg::seed_from_u64(3);
        let corners = [(0.5, 0.0), (0.1, 0.3), (-0.2, 0.25), (-0.2, -0.1), (0.2, -0.2)];
        let body = Polygon::new(corners.map(|(x, y)| Point::new(x, y)).to_vec());
        let footprint = Footprint::covering(body.expect("a polygon"));
        let body = footprint.body().expect("a polygon");
        let mut kept = [0; 2];
        for share in [0.002, 0.03, 0.4] {
            let frame = GridFrame::new(60, 60, 0.05, Pose::new(1.0, 2.0, 0.7)).expect("a size");
            let obstacles = ObstacleGrid::from_fn(frame, |_| random.random_bool(share));
            let field = ClearanceField::new(&obstacles).expect("a field");
            let place = frame.origin.transform(&Point::new(1.5, 1.5));
            let clearance = ExactClearance::new(&field, &place, 1.1);
            for _ in 0..200 {
                let near = |at: f64, random: &mut Pcg64Mcg| at + random.random_range(-0.4..0.4);
                let yaw = random.random_range(-4.0..4.0);
                let pose = Pose::new(near(place.x, &mut random), near(place.y, &mut random), yaw);
                let placed = body.mapped(|corner| frame.to_cell_units(&pose.transform(corner)));
                let distances =
                    clearance.squares.iter().map(|it| placed.distance_to_unit_square(it));
                let gap_m = distances.fold(1.1 / 0.05, f64::min) * 0.05;
                assert_eq!(clearance.gap_m(&footprint, &pose), gap_m);
                let above_m = f64::from_bits(gap_m.to_bits() + 1);
                assert!(clearance.keeps_gap(&footprint, &pose, gap_m));
                assert_eq!(clearance.keeps_gap(&footprint, &pose, above_m), gap_m >= 1.1);
                let limit_m = random.random_range(-0.1..0.4);
                assert_eq!(clearance.keeps_gap(&footprint, &pose, limit_m), gap_m >= limit_m);
                kept[usize::from(gap_m >= limit_m)] += 1;
            }
        }
        assert!(kept.iter().all(|&count| count > 50), "{kept:?}");
    }
}
