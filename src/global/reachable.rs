//! Flood fill of the cells reachable from a start.

use crate::geometry::Point;
use crate::map::{Cell, FreeSpace};

/// The free cell that is reachable from `start` and nearest to `goal` by its centre; ties go to the first in storage order.
/// None if the start is not free or outside the grid.
///
/// Only straight moves are needed: a diagonal move requires both adjacent cells to be free, so two straight moves replace it.
#[must_use]
pub fn nearest_reachable(space: &FreeSpace, start: Cell, goal: &Point) -> Option<Cell> {
    if !space.is_free(start) {
        return None;
    }
    let frame = space.frame();
    let goal = frame.to_cell_units(goal);
    let key = |cell: Cell| ((cell.center() - goal).norm_squared(), frame.index(cell));
    let mut best = (key(start), start);
    let mut seen = vec![false; frame.len()];
    seen[frame.index(start)] = true;
    let mut open = vec![start];
    while let Some(cell) = open.pop() {
        if key(cell) < best.0 {
            best = (key(cell), cell);
        }
        for (dx, dy) in [(1, 0), (0, 1), (-1, 0), (0, -1)] {
            let next = Cell::new(cell.column + dx, cell.row + dy);
            if space.is_free(next) && !seen[frame.index(next)] {
                seen[frame.index(next)] = true;
                open.push(next);
            }
        }
    }
    Some(best.1)
}
