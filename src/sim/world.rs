//! The truth: solid ground, bodies that move, and the gap between them and the robot.

use core::f64::consts::SQRT_2;

use crate::geometry::{Point, Pose};
use crate::map::{Cell, DistanceField, MovingDisc, ObstacleGrid};
use crate::robot::Footprint;

/// Everything the robot can touch.
///
/// Each obstacle cell is a solid square, and so is everything outside the grid; moving obstacles are discs. All gaps
/// are in metres, exact to rounding, between outlines; at or below zero there is contact.
#[derive(Clone, Debug)]
pub struct World {
    obstacles: ObstacleGrid,
    field: DistanceField,
    /// What moves, where it is now.
    pub moving: Vec<MovingDisc>,
}

impl World {
    /// A world where nothing moves yet.
    #[must_use]
    pub fn new(obstacles: ObstacleGrid) -> Self {
        let field = DistanceField::new(&obstacles);
        Self {
            obstacles,
            field,
            moving: Vec::new(),
        }
    }

    /// What stands still.
    #[must_use]
    pub const fn obstacles(&self) -> &ObstacleGrid {
        &self.obstacles
    }

    /// The smallest gap between the footprint and anything solid.
    #[must_use]
    pub fn gap_m(&self, footprint: &Footprint, pose: &Pose) -> f64 {
        self.gap_to_static_m(footprint, pose)
            .min(self.gap_to_moving_m(footprint, pose))
    }

    /// The smallest gap between the footprint and what stands still. Depth inside a solid is not measured: a disc
    /// with its centre there has a gap of minus its radius.
    #[must_use]
    pub fn gap_to_static_m(&self, footprint: &Footprint, pose: &Pose) -> f64 {
        footprint
            .at(pose)
            .map(|(center, radius)| self.distance_to_static_m(&center) - radius)
            .fold(f64::INFINITY, f64::min)
    }

    /// The smallest gap between the footprint and what moves; infinite where nothing does.
    #[must_use]
    pub fn gap_to_moving_m(&self, footprint: &Footprint, pose: &Pose) -> f64 {
        self.moving
            .iter()
            .map(|disc| footprint.gap_to_disc_m(pose, &disc.center(), disc.radius))
            .fold(f64::INFINITY, f64::min)
    }

    /// Distance from a point to the nearest solid square; zero inside one.
    fn distance_to_static_m(&self, point: &Point) -> f64 {
        let frame = self.obstacles.frame();
        let Some(cell) = frame.cell_of(point) else {
            return 0.0;
        };
        let units = frame.to_cell_units(point);
        let to_border = (units.x.min(f64::from(frame.width) - units.x))
            .min(units.y.min(f64::from(frame.height) - units.y));
        self.squares_from(&units, cell).min(to_border) * frame.resolution_m
    }

    /// Distance in cells from a point, given in cell units, to the nearest square of the grid; infinite if none.
    ///
    /// The field knows the distance from the cell's centre to the nearest obstacle's centre. No centre is nearer than
    /// that; and the nearest square's centre is farther by at most three half diagonals, one for the point's place
    /// in its cell, twice, and one for the square. So only a ring of cells need be looked at.
    fn squares_from(&self, point: &Point, cell: Cell) -> f64 {
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
                let place = Cell::new(column, row);
                if frame.contains(place) && self.obstacles.cells()[frame.index(place)] {
                    best = best.min(squared_distance_to_square(point, place));
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
