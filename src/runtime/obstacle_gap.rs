//! Gaps between a footprint and the obstacles of a map, exact to rounding.

use core::f64::consts::SQRT_2;

use crate::geometry::{Point, Pose};
use crate::map::{Cell, DistanceField, ObstacleGrid};
use crate::robot::Footprint;

/// Measures gaps to static obstacles.
///
/// Each obstacle cell is a solid square, and everything outside the grid is solid.
#[derive(Clone, Debug)]
pub struct ObstacleGap {
    obstacles: ObstacleGrid,
    field: DistanceField,
}

impl ObstacleGap {
    /// Prepares the obstacles of a map.
    #[must_use]
    pub fn new(obstacles: ObstacleGrid) -> Self {
        let field = DistanceField::new(&obstacles);
        Self { obstacles, field }
    }

    /// The obstacles.
    #[must_use]
    pub const fn obstacles(&self) -> &ObstacleGrid {
        &self.obstacles
    }

    /// The smallest gap between the footprint at a pose and any obstacle, metres; contact at or below zero. A disc with its
    /// centre inside an obstacle has a gap of minus its radius.
    #[must_use]
    pub fn gap_m(&self, footprint: &Footprint, pose: &Pose) -> f64 {
        footprint
            .at(pose)
            .map(|(center, radius)| self.distance_m(&center) - radius)
            .fold(f64::INFINITY, f64::min)
    }

    /// Distance from a point to the nearest solid square, metres; zero inside one.
    fn distance_m(&self, point: &Point) -> f64 {
        let frame = self.obstacles.frame();
        let Some(cell) = frame.cell_of(point) else {
            return 0.0;
        };
        let units = frame.to_cell_units(point);
        let to_border = (units.x.min(f64::from(frame.width) - units.x))
            .min(units.y.min(f64::from(frame.height) - units.y));
        self.distance_in_cells(&units, cell).min(to_border) * frame.resolution_m
    }

    /// Distance in cells from a point, given in cell units, to the nearest square of the grid; infinite without obstacles.
    ///
    /// The field holds the distance from the cell's centre to the nearest obstacle's centre; no centre is nearer. The centre
    /// of the nearest square is farther by at most three half diagonals: two for the position of the point in its cell, one
    /// for the square. So only a ring of cells is searched.
    fn distance_in_cells(&self, point: &Point, cell: Cell) -> f64 {
        let frame = self.obstacles.frame();
        let nearest = self.field.squared_cells()[frame.index(cell)];
        if nearest >= DistanceField::NO_OBSTACLE {
            return f64::INFINITY;
        }
        let nearest = f64::from(nearest);
        let reach = nearest.sqrt() + 1.5 * SQRT_2;
        let mut best = f64::INFINITY;
        let rows = reach.floor() as i32;
        for row in (cell.row - rows).max(0)..=(cell.row + rows).min(frame.height - 1) {
            let offset = f64::from(row - cell.row);
            let first = (nearest - offset * offset).max(0.0).sqrt().ceil() as i32;
            let last = (reach * reach - offset * offset).max(0.0).sqrt() as i32;
            let left = (cell.column - last).max(0)..=cell.column - first;
            let right = cell.column + first..=(cell.column + last).min(frame.width - 1);
            for column in left.chain(right) {
                let square = Cell::new(column, row);
                if frame.contains(square) && self.obstacles.cells()[frame.index(square)] {
                    best = best.min(squared_distance_to_square(point, square));
                }
            }
        }
        best.sqrt()
    }
}

/// Squared distance from a point in cell units to a cell's closed square; zero inside.
fn squared_distance_to_square(point: &Point, cell: Cell) -> f64 {
    let beyond = |at: f64, low: i32| {
        let low = f64::from(low);
        (low - at).max(at - (low + 1.0)).max(0.0)
    };
    let (dx, dy) = (beyond(point.x, cell.column), beyond(point.y, cell.row));
    dx * dx + dy * dy
}
