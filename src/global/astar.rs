//! A* on an 8-connected grid without corner cutting (paper, section 3.2; eq. 13).

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::cost::{DIAGONAL, STRAIGHT};
use super::heuristic::Heuristic;
use crate::map::{Cell, FreeSpace, GridFrame};

/// A path of cells and what it took to find it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Found {
    /// Start to goal, both included; each cell is a neighbour of the one before.
    pub cells: Vec<Cell>,
    /// Cost of the moves between them, in the units of [`STRAIGHT`].
    pub cost: u64,
    /// Cells taken off the open list and expanded, each at most once; the goal is not expanded.
    pub expanded: u32,
}

/// A search that found nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotFound {
    /// Cells expanded: all that can be reached from the start.
    pub expanded: u32,
}

/// The eight moves: four straight ones counter-clockwise, then the diagonals, each after the straight one of the same
/// place in its own four and before the next.
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

/// The cheapest path over free cells from start to goal.
///
/// A diagonal move needs both cells beside it free. Of equal estimates the cell that cost more to reach is expanded
/// first, then the one of lower index, so the path depends on nothing but the input. No cell is expanded twice: every
/// admissible heuristic here is consistent, so its path is the shortest all the same, and the others gain little from
/// a second visit but pay up to ten times the expansions.
///
/// # Errors
/// [`NotFound`] when no path joins the two, as when one of them is not free or lies outside the grid.
pub fn astar(
    space: &FreeSpace,
    start: Cell,
    goal: Cell,
    heuristic: Heuristic,
) -> Result<Found, NotFound> {
    let mut expanded = 0;
    if !(space.is_free(start) && space.is_free(goal)) {
        return Err(NotFound { expanded });
    }
    let frame = space.frame();
    let estimator = heuristic.estimator(start, goal);
    let goal_index = frame.index(goal);
    let mut labels = Labels::new(frame);
    let mut open = BinaryHeap::new();
    labels.reach(frame.index(start), 0, Labels::START);
    open.push(Open {
        estimate: estimator.cost(start),
        cost: 0,
        index: frame.index(start) as u32,
    });
    while let Some(Open { cost, index, .. }) = open.pop() {
        let index = index as usize;
        if index == goal_index {
            let cells = labels.trace_back(frame, goal);
            return Ok(Found {
                cells,
                cost,
                expanded,
            });
        }
        if !labels.close(index) {
            continue;
        }
        expanded += 1;
        for (number, next) in neighbours(space, frame.cell_at(index)) {
            let next_cost = cost + if number < 4 { STRAIGHT } else { DIAGONAL };
            let next_index = frame.index(next);
            if labels.reach(next_index, next_cost, number) {
                open.push(Open {
                    estimate: next_cost + estimator.cost(next),
                    cost: next_cost,
                    index: next_index as u32,
                });
            }
        }
    }
    Err(NotFound { expanded })
}

/// What the search knows of each cell. All zeros at first, which the system hands out without touching the memory: a
/// short query on a large map pays only for the cells it visits.
struct Labels {
    /// Cheapest cost so far, where the cell has been reached.
    costs: Vec<u64>,
    /// Zero where not reached; else the move that led here plus one, and [`Self::CLOSED`] once expanded.
    states: Vec<u8>,
}

impl Labels {
    /// Stands for the move that led to the start.
    const START: u8 = 8;
    const CLOSED: u8 = 0x80;

    fn new(frame: &GridFrame) -> Self {
        Self {
            costs: vec![0; frame.len()],
            states: vec![0; frame.len()],
        }
    }

    /// Notes a way to a cell, unless it is no cheaper than one known or the cell is closed; returns whether it did.
    fn reach(&mut self, index: usize, cost: u64, number: u8) -> bool {
        let state = &mut self.states[index];
        let is_better = *state == 0 || (*state & Self::CLOSED == 0 && cost < self.costs[index]);
        if is_better {
            *state = number + 1;
            self.costs[index] = cost;
        }
        is_better
    }

    /// Closes a cell; false when it was closed already.
    fn close(&mut self, index: usize) -> bool {
        let was_open = self.states[index] & Self::CLOSED == 0;
        self.states[index] |= Self::CLOSED;
        was_open
    }

    fn trace_back(&self, frame: &GridFrame, goal: Cell) -> Vec<Cell> {
        let mut cells = vec![goal];
        let mut cell = goal;
        let number = |cell| usize::from((self.states[frame.index(cell)] & !Self::CLOSED) - 1);
        while let Some(&(dx, dy)) = MOVES.get(number(cell)) {
            cell = Cell::new(cell.column - dx, cell.row - dy);
            cells.push(cell);
        }
        cells.reverse();
        cells
    }
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
    let after = move |number: u8| {
        let (dx, dy) = MOVES[usize::from(number)];
        Cell::new(cell.column + dx, cell.row + dy)
    };
    let straight = [0, 1, 2, 3].map(|number| space.is_free(after(number)));
    (0_u8..8).filter_map(move |number| {
        let place = usize::from(number % 4);
        let next = after(number);
        let may_be_made = if number < 4 {
            straight[place]
        } else {
            straight[place] && straight[(place + 1) % 4] && space.is_free(next)
        };
        may_be_made.then_some((number, next))
    })
}
