//! The cost of a shortest path by a plain Dijkstra search, the reference for exact searches. The searches share only the
//! costs of moves with it.

use core::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::global::{DIAGONAL, STRAIGHT};
use crate::map::{Cell, FreeSpace};

/// Returns the smallest cost of moves from a cell to another; none without a path.
pub(super) fn shortest_cost(space: &FreeSpace, start: Cell, goal: Cell) -> Option<u64> {
    let frame = space.frame();
    if !(space.is_free(start) && space.is_free(goal)) {
        return None;
    }
    let mut least = vec![u64::MAX; frame.len()];
    least[frame.index(start)] = 0;
    let mut open = BinaryHeap::from([(Reverse(0), frame.index(start))]);
    while let Some((Reverse(cost), index)) = open.pop() {
        let Cell { column, row } = frame.cell_at(index);
        if Cell::new(column, row) == goal {
            return Some(cost);
        }
        if cost > least[index] {
            continue;
        }
        let is_free = |right: i32, up: i32| space.is_free(Cell::new(column + right, row + up));
        for (right, up) in (-1..=1).flat_map(|up| (-1..=1).map(move |right| (right, up))) {
            let moves = (right, up) != (0, 0);
            if !(moves && is_free(right, up) && is_free(right, 0) && is_free(0, up)) {
                continue;
            }
            let step = if right != 0 && up != 0 { DIAGONAL } else { STRAIGHT };
            let neighbour = frame.index(Cell::new(column + right, row + up));
            if cost + step < least[neighbour] {
                least[neighbour] = cost + step;
                open.push((Reverse(cost + step), neighbour));
            }
        }
    }
    None
}
