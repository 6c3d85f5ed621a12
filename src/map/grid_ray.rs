//! The cells along a straight ray.

use super::Cell;
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

/// Crossings of a ray with the cell borders of one axis.
pub(super) struct Crossing {
    /// -1, 0 or 1 cells.
    pub(super) step: i32,
    /// Distance to the next border; infinite for a ray across the axis.
    pub(super) next: f64,
    /// Distance between two borders.
    pub(super) pitch: f64,
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

impl Crossing {
    pub(super) fn new(start: f64, direction: f64) -> Self {
        let within = start - start.floor();
        if direction > 0.0 {
            Self { step: 1, next: (1.0 - within) / direction, pitch: 1.0 / direction }
        } else if direction < 0.0 {
            Self { step: -1, next: within / -direction, pitch: 1.0 / -direction }
        } else {
            Self { step: 0, next: f64::INFINITY, pitch: f64::INFINITY }
        }
    }

    /// Crosses the next border; returns its distance.
    pub(super) fn cross(&mut self, coordinate: &mut i32) -> f64 {
        *coordinate = coordinate.saturating_add(self.step);
        let at = self.next;
        self.next += self.pitch;
        at
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
