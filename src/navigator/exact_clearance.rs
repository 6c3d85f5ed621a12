//! Exact distances to the occupied cells near the robot.
//!
//! The distance field has one distance for all points of a cell: it is good to a cell's diagonal. The clearance of a robot
//! that leaves a corner is smaller.

use crate::geometry::{Point, Pose};
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
        let middle = frame.to_cell_units(place);
        let reach = reach_m / frame.resolution_m;
        let span = |at: f64, cells: i32| {
            let first = ((at - reach).floor() as i32).max(0);
            first..=((at + reach).floor() as i32).min(cells - 1)
        };
        let units = field.units();
        let squares = span(middle.y, frame.height)
            .flat_map(|row| span(middle.x, frame.width).map(move |column| Cell::new(column, row)))
            .filter(|&cell| units[frame.index(cell)] == 0)
            .map(|cell| Point::new(f64::from(cell.column), f64::from(cell.row)))
            .collect();
        Self { frame, squares, reach_m }
    }

    /// The gap between the body at a pose and the nearest occupied cell, metres: at or below zero they touch. At most the
    /// distance within which cells were collected.
    pub fn gap_m(&self, footprint: &Footprint, pose: &Pose) -> f64 {
        if let Some(body) = footprint.body() {
            return self.polygon_gap_m(body, footprint.body_radius_m(), pose);
        }
        let gap = |(center, radius_m): (Point, f64)| {
            let units = self.frame.to_cell_units(&center);
            let squared = |square: &Point| squared_distance(square, &units);
            let nearest = self.squares.iter().map(squared).fold(f64::INFINITY, f64::min);
            nearest.sqrt() * self.frame.resolution_m - radius_m
        };
        footprint.at(pose).map(gap).fold(self.reach_m, f64::min)
    }

    /// As [`Self::gap_m`], for a polygon within a circle around the robot's origin.
    fn polygon_gap_m(&self, body: &Polygon, radius_m: f64, pose: &Pose) -> f64 {
        let resolution_m = self.frame.resolution_m;
        let body = body.mapped(|corner| self.frame.to_cell_units(&pose.transform(corner)));
        let (origin, radius) =
            (self.frame.to_cell_units(&pose.position()), radius_m / resolution_m);
        let mut least = self.reach_m / resolution_m;
        for square in &self.squares {
            let within = least + radius;
            if squared_distance(square, &origin) < within * within {
                least = least.min(body.distance_to_unit_square(square));
            }
        }
        least * resolution_m
    }
}

/// Squared distance between a unit square, given by its lower left corner, and a point, in cells.
fn squared_distance(square: &Point, point: &Point) -> f64 {
    let beyond = |at: f64, low: f64| (low - at).max(at - low - 1.0).max(0.0);
    let (dx, dy) = (beyond(point.x, square.x), beyond(point.y, square.y));
    dx * dx + dy * dy
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::ObstacleGrid;

    #[test]
    fn gap_is_the_distance_to_the_nearest_square() {
        let frame = GridFrame::new(40, 40, 0.1, Pose::new(1.0, 2.0, 0.3)).expect("a valid size");
        let mut obstacles = ObstacleGrid::new(frame, vec![false; frame.len()]);
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
}
