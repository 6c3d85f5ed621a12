//! Flood fill of free cells.

use std::collections::VecDeque;

use crate::map::{Cell, FreeSpace};

/// Returns the free cells within this number of moves along rows and columns from a free cell, the cell itself first. A
/// diagonal move needs both adjacent cells free, so these moves reach all cells that a search does, in up to 1.41 times the
/// length.
pub(super) fn flood_fill(space: &FreeSpace, start: Cell, most_steps: u32) -> Vec<Cell> {
    let frame = space.frame();
    let mut seen = vec![false; frame.len()];
    seen[frame.index(start)] = true;
    let mut reached = vec![start];
    let mut queue = VecDeque::from([(start, 0)]);
    while let Some((Cell { column, row }, steps)) = queue.pop_front() {
        if steps == most_steps {
            continue;
        }
        for (right, up) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
            let next = Cell::new(column + right, row + up);
            if space.is_free(next) && !seen[frame.index(next)] {
                seen[frame.index(next)] = true;
                reached.push(next);
                queue.push_back((next, steps + 1));
            }
        }
    }
    reached
}
