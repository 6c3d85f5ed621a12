//! Whether a straight way between two points stays on free cells.

use crate::geometry::Point;
use crate::map::{Cell, FreeSpace};

/// A segment this near to a cell touches it, in cells: far above the rounding of the arithmetic here (1e-11 on grids
/// of 32,767 cells), far below anything that matters.
const TOUCH: f64 = 1e-9;

/// Whether every cell that the segment touches is free, cells that it only grazes included: so a segment through a
/// corner of the lattice needs all four cells around it, and no corner is cut. Exact on the safe side.
///
/// Two points in one free cell see each other even on its border: all of a free cell's closed square is clear.
#[must_use]
pub fn is_clear(space: &FreeSpace, from: &Point, to: &Point) -> bool {
    let frame = space.frame();
    if let (Some(one), Some(other)) = (frame.cell_of(from), frame.cell_of(to))
        && one == other
    {
        return space.is_free(one);
    }
    let (a, b) = (frame.to_cell_units(from), frame.to_cell_units(to));
    let (low, high) = if a.y <= b.y { (a, b) } else { (b, a) };
    let rise = high.y - low.y;
    let first = (low.y - TOUCH).floor() as i32;
    let last = (high.y + TOUCH).floor() as i32;
    (first..=last).all(|row| {
        // The part of the segment within this row, and the columns it spans.
        let share = |y: f64| {
            if rise == 0.0 {
                0.0
            } else {
                ((y - low.y) / rise).clamp(0.0, 1.0)
            }
        };
        let x_at = |share: f64| low.x + (high.x - low.x) * share;
        let enters = x_at(share(f64::from(row) - TOUCH));
        let leaves = if rise == 0.0 {
            high.x
        } else {
            x_at(share(f64::from(row + 1) + TOUCH))
        };
        let left = (enters.min(leaves) - TOUCH).floor() as i32;
        let right = (enters.max(leaves) + TOUCH).floor() as i32;
        (left..=right).all(|column| space.is_free(Cell::new(column, row)))
    })
}
