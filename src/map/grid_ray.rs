//! The cells along a straight ray.

use super::Cell;
use super::ray_caster::Crossing;
use crate::geometry::{Point, Vector};

/// An endless iterator of the cells along a ray, each with the distance at which the ray enters it.
///
/// The traversal of Amanatides and Woo (1987). Start, direction and distances are in cell units; the direction has
/// unit length. A ray through a corner enters the column's neighbour first. Start and direction must be finite.
pub(crate) struct GridRay {
    cell: Cell,
    entered: f64,
    across_columns: Crossing,
    across_rows: Crossing,
}

impl GridRay {
    pub(crate) fn new(start: &Point, direction: &Vector) -> Self {
        Self {
            cell: Cell::new(start.x.floor() as i32, start.y.floor() as i32),
            entered: 0.0,
            across_columns: Crossing::new(start.x, direction.x),
            across_rows: Crossing::new(start.y, direction.y),
        }
    }
}

impl Iterator for GridRay {
    type Item = (Cell, f64);

    fn next(&mut self) -> Option<Self::Item> {
        let entry = (self.cell, self.entered);
        self.entered = if self.across_columns.next <= self.across_rows.next {
            self.across_columns.cross(&mut self.cell.column)
        } else {
            self.across_rows.cross(&mut self.cell.row)
        };
        Some(entry)
    }
}
