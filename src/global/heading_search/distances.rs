//! Distances to the goal over cells: the heuristic of the lattice search.

use core::cmp::Reverse;
use std::collections::BinaryHeap;

use super::cost::{NARROW_PRICE, length_cost};
use super::headings::PARTS;
use crate::map::{Cell, FreeSpace};

/// Moves to the neighbours of a cell.
pub(super) const NEIGHBOURS: [(i32, i32); 8] =
    [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)];

/// Further cost to which distances are computed beyond that of the start, in quarters: a path that the body cannot drive is
/// longer. Most of a large map is farther away.
const BEYOND_QUARTERS: u32 = 1;

/// Cost from each cell to the goal for a robot as wide as its inscribed circle, up to a limit.
pub(super) struct Distances {
    costs: Vec<u32>,
    /// Every cell with a greater cost counts with this one.
    limit: u32,
}

impl Distances {
    /// Computes the costs over the cells of `passable`; `None` where that from the start exceeds `most`. Metres outside `open`
    /// have their price.
    pub fn new(
        passable: &FreeSpace,
        open: &FreeSpace,
        [start, goal]: [Cell; 2],
        most: u64,
    ) -> Option<Self> {
        let frame = passable.frame();
        let start = frame.index(start);
        let mut limit = u32::try_from(most).unwrap_or(u32::MAX);
        let mut costs = vec![u32::MAX; frame.len()];
        let mut queue = BinaryHeap::new();
        if passable.is_free(goal) {
            costs[frame.index(goal)] = 0;
            queue.push((Reverse(0_u32), frame.index(goal)));
        }
        let sides = [1.0, core::f64::consts::SQRT_2]
            .map(|cells| length_cost(cells * f64::from(PARTS)) as u32);
        while let Some((Reverse(cost), index)) = queue.pop() {
            if cost > limit {
                break;
            }
            if cost > costs[index] {
                continue;
            }
            if index == start {
                limit = limit.min(cost.saturating_add(cost / 4 * BEYOND_QUARTERS));
            }
            let cell = frame.cell_at(index);
            let is_open = open.is_free(cell);
            for (dx, dy) in NEIGHBOURS {
                let next = Cell::new(cell.column + dx, cell.row + dy);
                if !passable.is_free(next) {
                    continue;
                }
                let length = sides[usize::from(dx != 0 && dy != 0)];
                let is_narrow = !(is_open && open.is_free(next));
                let price = if is_narrow { NARROW_PRICE as u32 } else { 1 };
                let next_cost = cost.saturating_add(length.saturating_mul(price));
                let index = frame.index(next);
                if next_cost < costs[index] {
                    costs[index] = next_cost;
                    queue.push((Reverse(next_cost), index));
                }
            }
        }
        (costs[start] <= limit && costs[start] < u32::MAX).then_some(Self { costs, limit })
    }

    /// The cost from the cell at an index, or less.
    pub fn cost(&self, index: usize) -> u64 {
        u64::from(self.costs[index].min(self.limit))
    }
}
