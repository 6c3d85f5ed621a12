//! How near a path comes to obstacles.

use core::f64::consts::SQRT_2;

use super::Path;
use crate::geometry::{Point, nearest_on_segment};
use crate::map::{Cell, DistanceField, GridFrame, ObstacleGrid};

/// How near paths come to the obstacles of one map: what only the map decides is found once.
pub struct PathClearance<'a> {
    obstacles: &'a ObstacleGrid,
    field: DistanceField,
}

impl<'a> PathClearance<'a> {
    /// Among these obstacles.
    #[must_use]
    pub fn new(obstacles: &'a ObstacleGrid) -> Self {
        Self {
            obstacles,
            field: DistanceField::new(obstacles),
        }
    }

    /// The smallest distance from a path to any obstacle cell's square, metres, zero where it touches one; infinite on a
    /// map without obstacles. Exact up to rounding. Ground off the map is no obstacle here.
    #[must_use]
    pub fn min_m(&self, path: &Path) -> f64 {
        let frame = self.obstacles.frame();
        let pieces = pieces(path, frame, &self.field);
        // The middles alone tell which pieces the nearest obstacle can be near to.
        let mut least = pieces
            .iter()
            .map(|piece| piece.at_most)
            .fold(f64::INFINITY, f64::min);
        if least == f64::INFINITY {
            return least;
        }
        for piece in &pieces {
            if piece.at_least < least {
                least = least.min(piece.distance_within(least, self.obstacles));
            }
        }
        least * frame.resolution_m
    }
}

/// [`PathClearance::min_m`] of a single path.
#[must_use]
pub fn min_clearance_m(path: &Path, obstacles: &ObstacleGrid) -> f64 {
    PathClearance::new(obstacles).min_m(path)
}

/// Pieces of a path are at most this long, in cells.
const PIECE_CELLS: f64 = 2.0;

/// A short straight part of a path, and bounds on its distance to the nearest obstacle square; all in cells.
struct Piece {
    from: Point,
    to: Point,
    at_least: f64,
    at_most: f64,
}

fn pieces(path: &Path, frame: &GridFrame, field: &DistanceField) -> Vec<Piece> {
    let points: Vec<Point> = path
        .points()
        .iter()
        .map(|point| frame.to_cell_units(point))
        .collect();
    let mut pieces = Vec::new();
    // A path of a single point is its own only piece.
    let ends = points
        .iter()
        .zip(points.iter().skip(1).chain(points.last()));
    for (from, to) in ends {
        let chord = to - from;
        let count = (chord.norm() / PIECE_CELLS).ceil().max(1.0);
        let at = |number: usize| from + chord * (number as f64 / count);
        let parts = 0..count as usize;
        pieces.extend(parts.map(|number| Piece::new(at(number), at(number + 1), frame, field)));
    }
    pieces
}

impl Piece {
    fn new(from: Point, to: Point, frame: &GridFrame, field: &DistanceField) -> Self {
        let middle = from + (to - from) / 2.0;
        // All obstacles lie inside the grid, so moving a point into it brings it nearer to each.
        let inside = |at: f64, side: i32| (at as i32).clamp(0, side - 1);
        let cell = Cell::new(
            inside(middle.x, frame.width),
            inside(middle.y, frame.height),
        );
        let between_centers = field.distance_m(cell) / frame.resolution_m;
        let half_length = (to - from).norm() / 2.0;
        Self {
            from,
            to,
            // Half a diagonal at most from the middle to its cell's centre, and from the obstacle's to its corner.
            at_least: between_centers - SQRT_2 - half_length,
            at_most: (between_centers + (middle - cell.center()).norm() - 0.5).max(0.0),
        }
    }

    /// Distance to the nearest obstacle square among those within `reach`; infinite when there is none.
    fn distance_within(&self, reach: f64, obstacles: &ObstacleGrid) -> f64 {
        let frame = obstacles.frame();
        let span = |one: f64, other: f64, side: i32| {
            let low = (one.min(other) - reach).floor() as i32 - 1;
            let high = (one.max(other) + reach).floor() as i32 + 1;
            low.max(0)..=high.min(side - 1)
        };
        let columns = span(self.from.x, self.to.x, frame.width);
        let mut least = f64::INFINITY;
        for row in span(self.from.y, self.to.y, frame.height) {
            for column in columns.clone() {
                let cell = Cell::new(column, row);
                if obstacles.is_blocked(cell) {
                    least = least.min(self.distance_to_square(cell));
                }
            }
        }
        least
    }

    /// Zero where they meet; else the least of the ends' distances to the square and its corners' to the piece.
    fn distance_to_square(&self, cell: Cell) -> f64 {
        let low = Point::new(f64::from(cell.column), f64::from(cell.row));
        if self.meets_unit_square(&low) {
            return 0.0;
        }
        let from_end = |end: &Point| {
            let beyond = |at: f64, low: f64| (low - at).max(at - low - 1.0).max(0.0);
            libm::hypot(beyond(end.x, low.x), beyond(end.y, low.y))
        };
        let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)];
        corners
            .iter()
            .map(|&(x, y)| self.distance_to_point(&Point::new(low.x + x, low.y + y)))
            .fold(from_end(&self.from).min(from_end(&self.to)), f64::min)
    }

    /// Whether some part of the piece lies in the closed unit square with this lower left corner.
    fn meets_unit_square(&self, low: &Point) -> bool {
        let whole = self.to - self.from;
        let (mut enters, mut leaves) = (0.0_f64, 1.0_f64);
        for axis in 0..2 {
            let (at, step) = (self.from[axis] - low[axis], whole[axis]);
            if step == 0.0 {
                if !(0.0..=1.0).contains(&at) {
                    return false;
                }
            } else {
                let (one, other) = (-at / step, (1.0 - at) / step);
                enters = enters.max(one.min(other));
                leaves = leaves.min(one.max(other));
            }
        }
        enters <= leaves
    }

    fn distance_to_point(&self, point: &Point) -> f64 {
        (point - nearest_on_segment(&self.from, &self.to, point)).norm()
    }
}
