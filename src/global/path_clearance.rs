//! Exact clearance of a path from obstacles.

use core::f64::consts::SQRT_2;

use super::Path;
use crate::geometry::{Point, segment_to_unit_square};
use crate::map::{Cell, DistanceField, GridFrame, ObstacleGrid};

/// Computes the clearance of paths on one map; the distance field is computed once.
pub struct PathClearance<'a> {
    obstacles: &'a ObstacleGrid,
    field: DistanceField,
}

impl<'a> PathClearance<'a> {
    /// Prepares the clearance computation for these obstacles.
    #[must_use]
    pub fn new(obstacles: &'a ObstacleGrid) -> Self {
        Self { obstacles, field: DistanceField::new(obstacles) }
    }

    /// The smallest distance from a path to the square of any obstacle cell, metres, exact up to rounding: zero on contact,
    /// infinite on a map without obstacles. The area outside the map is no obstacle here.
    #[must_use]
    pub fn min_m(&self, path: &Path) -> f64 {
        let frame = self.obstacles.frame();
        let pieces = pieces(path, frame, &self.field);
        // Upper bounds from the middles of the pieces select the pieces to examine.
        let mut min = pieces.iter().map(|piece| piece.upper_bound).fold(f64::INFINITY, f64::min);
        if min == f64::INFINITY {
            return min;
        }
        for piece in &pieces {
            if piece.lower_bound < min {
                min = min.min(piece.distance_within(min, self.obstacles));
            }
        }
        min * frame.resolution_m
    }
}

/// Largest length of a piece of a path, cells.
const MAX_PIECE_CELLS: f64 = 2.0;

/// A short straight part of a path, with bounds of its distance to the nearest obstacle square. All lengths in cells.
struct Piece {
    from: Point,
    to: Point,
    lower_bound: f64,
    upper_bound: f64,
}

fn pieces(path: &Path, frame: &GridFrame, field: &DistanceField) -> Vec<Piece> {
    let points: Vec<Point> = path.points().iter().map(|point| frame.to_cell_units(point)).collect();
    let mut pieces = Vec::new();
    // A path of a single point is one piece of length zero.
    let ends = points.iter().zip(points.iter().skip(1).chain(points.last()));
    for (from, to) in ends {
        let chord = to - from;
        let count = (chord.norm() / MAX_PIECE_CELLS).ceil().max(1.0);
        let at = |number: usize| from + chord * (number as f64 / count);
        let parts = 0..count as usize;
        pieces.extend(parts.map(|number| Piece::new(at(number), at(number + 1), frame, field)));
    }
    pieces
}

impl Piece {
    fn new(from: Point, to: Point, frame: &GridFrame, field: &DistanceField) -> Self {
        let middle = from + (to - from) / 2.0;
        // All obstacles lie inside the grid, so clamping a point to it reduces the distance to each.
        let inside = |at: f64, side: i32| (at as i32).clamp(0, side - 1);
        let cell = Cell::new(inside(middle.x, frame.width), inside(middle.y, frame.height));
        let between_centers = field.distance_m(cell) / frame.resolution_m;
        let half_length = (to - from).norm() / 2.0;
        Self {
            from,
            to,
            // At most half a diagonal from the middle to its cell's centre, and from the obstacle's centre to its corner.
            lower_bound: between_centers - SQRT_2 - half_length,
            upper_bound: (between_centers + (middle - cell.center()).norm() - 0.5).max(0.0),
        }
    }

    /// Distance to the nearest obstacle square within `reach`; infinite if there is none.
    fn distance_within(&self, reach: f64, obstacles: &ObstacleGrid) -> f64 {
        let frame = obstacles.frame();
        let span = |one: f64, other: f64, side: i32| {
            let low = ((one.min(other) - reach).floor() as i32).saturating_sub(1);
            let high = ((one.max(other) + reach).floor() as i32).saturating_add(1);
            low.max(0)..=high.min(side - 1)
        };
        let columns = span(self.from.x, self.to.x, frame.width);
        let mut squared = f64::INFINITY;
        for row in span(self.from.y, self.to.y, frame.height) {
            for column in columns.clone() {
                let cell = Cell::new(column, row);
                if obstacles.is_blocked(cell) {
                    squared =
                        squared.min(segment_to_unit_square(&self.from, &self.to, &cell.corner()));
                }
            }
        }
        squared.sqrt()
    }
}
