//! A* on an 8-connected grid without corner cutting (paper, section 3.2; eq. 13).

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::cost::{DIAGONAL, STRAIGHT};
use super::heuristic::Heuristic;
use crate::map::{Cell, FreeSpace};

/// A path of cells and what it took to find it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Found {
    /// Start to goal, both included; each cell is a neighbour of the one before.
    pub cells: Vec<Cell>,
    /// Cost in the units of [`STRAIGHT`].
    pub cost: u64,
    /// Cells taken off the open list and expanded, re-expansions included.
    pub expanded: u32,
}

/// A search that found nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotFound {
    /// Cells expanded.
    pub expanded: u32,
}

/// The eight moves, straight ones first.
const MOVES: [(i32, i32); 8] = [
    (1, 0),
    (0, 1),
    (-1, 0),
    (0, -1),
    (1, 1),
    (-1, 1),
    (-1, -1),
    (1, -1),
];

/// Not reached yet.
const UNREACHED: u64 = u64::MAX;
/// The start has no predecessor.
const NO_MOVE: u8 = 8;

/// The cheapest path over free cells from start to goal, both of which must be free.
///
/// A diagonal move needs both cells beside it free. Of equal estimates the one nearer to the goal is expanded first,
/// then the one of lower index, so the path depends on nothing but the input. A cell reached more cheaply after its
/// expansion is expanded again: with an admissible heuristic the path is the shortest even where the heuristic is not
/// consistent.
///
/// # Errors
/// [`NotFound`] when no path joins the two.
pub fn astar(
    space: &FreeSpace,
    start: Cell,
    goal: Cell,
    heuristic: Heuristic,
) -> Result<Found, NotFound> {
    let frame = space.frame();
    let estimator = heuristic.estimator(start, goal);
    let mut costs = vec![UNREACHED; frame.len()];
    let mut came_by = vec![NO_MOVE; frame.len()];
    let mut open = BinaryHeap::new();
    let mut expanded = 0;
    let goal_index = frame.index(goal);
    costs[frame.index(start)] = 0;
    open.push(Open {
        estimate: estimator.cost(start),
        cost: 0,
        index: frame.index(start) as u32,
    });
    while let Some(Open { cost, index, .. }) = open.pop() {
        let index = index as usize;
        if cost > costs[index] {
            continue;
        }
        if index == goal_index {
            let cells = trace_back(frame.cell_at(index), &came_by, |cell| frame.index(cell));
            return Ok(Found {
                cells,
                cost,
                expanded,
            });
        }
        expanded += 1;
        let cell = frame.cell_at(index);
        for (number, next) in neighbours(space, cell) {
            let next_cost = cost + if number < 4 { STRAIGHT } else { DIAGONAL };
            let next_index = frame.index(next);
            if next_cost < costs[next_index] {
                costs[next_index] = next_cost;
                came_by[next_index] = number;
                let estimate = next_cost + estimator.cost(next);
                open.push(Open {
                    estimate,
                    cost: next_cost,
                    index: next_index as u32,
                });
            }
        }
    }
    Err(NotFound { expanded })
}

/// A cell on the open list; the greatest is expanded first.
#[derive(PartialEq, Eq)]
struct Open {
    estimate: u64,
    cost: u64,
    index: u32,
}

impl Ord for Open {
    fn cmp(&self, other: &Self) -> core::cmp::Ordering {
        let key = |open: &Self| (Reverse(open.estimate), open.cost, Reverse(open.index));
        key(self).cmp(&key(other))
    }
}

impl PartialOrd for Open {
    fn partial_cmp(&self, other: &Self) -> Option<core::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

/// Numbers of the moves that may be made from a cell, and where they lead.
fn neighbours(space: &FreeSpace, cell: Cell) -> impl Iterator<Item = (u8, Cell)> + '_ {
    let at = move |dx: i32, dy: i32| Cell::new(cell.column + dx, cell.row + dy);
    (0_u8..8).filter_map(move |number| {
        let (dx, dy) = MOVES[usize::from(number)];
        let beside_free = number < 4 || (space.is_free(at(dx, 0)) && space.is_free(at(0, dy)));
        (beside_free && space.is_free(at(dx, dy))).then(|| (number, at(dx, dy)))
    })
}

fn trace_back(goal: Cell, came_by: &[u8], index: impl Fn(Cell) -> usize) -> Vec<Cell> {
    let mut cells = vec![goal];
    let mut cell = goal;
    while let Some(&(dx, dy)) = MOVES.get(usize::from(came_by[index(cell)])) {
        cell = Cell::new(cell.column - dx, cell.row - dy);
        cells.push(cell);
    }
    cells.reverse();
    cells
}
