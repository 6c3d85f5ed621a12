//! Where one gets from a place.

use std::collections::VecDeque;

use crate::map::{Cell, FreeSpace};

/// The free cells that so many moves along rows and columns lead to from a free cell, itself the first. Since a diagonal
/// move needs both cells beside it free, these moves reach all that a search does, in up to 1.41 times the length.
pub(super) fn within_steps(space: &FreeSpace, start: Cell, most_steps: u32) -> Vec<Cell> {
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
