//! Jump point search: the same path lengths as A* on a uniform grid, with far fewer expansions.
//!
//! Of all paths of equal length, the one that moves diagonally first is kept (Harabor and Grastien, 2011, 2014). A cell is
//! then expanded only where an obstacle next to a straight run ends, since only there a path may turn; all others are jumped
//! over. Without corner cutting, that is the cell past the obstacle's end, and diagonal runs have no such cells. Rows are
//! scanned 64 cells at a time, columns as rows of the transposed grid. A diagonal run is expanded immediately: the stops of
//! its straight side runs are reached from its start.

use super::astar::{Outcome, START};
use super::labels::{Arrival, Labels};
use super::moves::{MOVES, Node};
use super::open_list::{Buckets, OpenList};
use crate::global::heuristic::{DIAGONAL, STRAIGHT, octile};
use crate::map::{BitGrid, Cell, FreeSpace};

/// A search in progress.
pub(super) struct Jumps<'a> {
    pub space: &'a FreeSpace,
    pub goal: Node,
    pub labels: &'a mut Labels,
    pub open: &'a mut Buckets,
    /// For each reached cell, the start cell of its run.
    pub parents: &'a mut [u32],
    /// Cost of the best path found to the goal.
    pub best: u64,
}

/// A run in progress: its start cell and that cell's cost.
#[derive(Clone, Copy)]
struct Run {
    from: Node,
    cost: u64,
}

impl Jumps<'_> {
    /// Labels cells until the cheapest path to the goal is known, as [`super::astar::search`] does.
    pub fn search(&mut self, start: Node) -> Outcome {
        let frame = self.space.frame();
        let mut expanded = 0;
        self.reach(start, 0, START, start);
        while let Some((node, bound)) = self.open.pop() {
            if self.best <= bound {
                break;
            }
            let Some((cost, arrival)) = self.labels.expand(node.index(frame)) else {
                continue;
            };
            if cost + self.estimate(node.cell()) >= self.best {
                continue;
            }
            expanded += 1;
            let run = Run { from: node, cost };
            if arrival == START {
                for direction in 0..4 {
                    self.run_straight(run, node.cell(), 0, direction);
                    self.run_diagonally(run, direction, (direction + 1) % 4);
                }
            } else {
                self.turn(run, usize::from(arrival));
            }
        }
        Outcome { cost: (self.best < u64::MAX).then_some(self.best), expanded }
    }

    /// Continues from a cell reached by a straight run, and turns to each side on which an obstacle ended.
    fn turn(&mut self, run: Run, ahead: usize) {
        let Cell { column, row } = run.from.cell();
        self.run_straight(run, run.from.cell(), 0, ahead);
        let (dx, dy) = MOVES[ahead];
        for side in [(ahead + 1) % 4, (ahead + 3) % 4] {
            let (sx, sy) = MOVES[side];
            let (free, _) = self.space.bits();
            let adjacent = free.position(column + sx, row + sy);
            let behind = free.position(column + sx - dx, row + sy - dy);
            if free.at(adjacent) && !free.at(behind) {
                self.run_straight(run, run.from.cell(), 0, side);
                self.run_diagonally(run, ahead, side);
            }
        }
    }

    /// Scans straight ahead, in one of the first four [`MOVES`], from a cell that the run reached at an additional cost.
    #[inline]
    fn run_straight(&mut self, run: Run, from: Cell, further: u64, direction: usize) {
        let (rows, columns) = self.space.bits();
        let goal = self.goal.cell();
        let (bits, along, across, goal_along, goal_across) = if direction.is_multiple_of(2) {
            (rows, from.column, from.row, goal.column, goal.row)
        } else {
            (columns, from.row, from.column, goal.row, goal.column)
        };
        let position = bits.position(along, across);
        let (stop, to_goal) = if direction < 2 {
            (look_ahead(bits, position), goal_along - along)
        } else {
            (look_back(bits, position), along - goal_along)
        };
        let (dx, dy) = MOVES[direction];
        let steps = if across == goal_across && (1..=stop.steps).contains(&to_goal) {
            to_goal
        } else if stop.may_turn {
            stop.steps
        } else {
            return;
        };
        let to = Node::new(Cell::new(from.column + dx * steps, from.row + dy * steps));
        let cost = run.cost + further + steps as u64 * STRAIGHT;
        self.reach(to, cost, direction as Arrival, run.from);
    }

    /// Moves diagonally between two straight directions as far as possible, and scans along both from every cell.
    fn run_diagonally(&mut self, run: Run, one: usize, other: usize) {
        let (free, _) = self.space.bits();
        let (dx, dy) = (MOVES[one].0 + MOVES[other].0, MOVES[one].1 + MOVES[other].1);
        let stride = free.stride() as isize * dy as isize;
        let mut cell = run.from.cell();
        let mut position = free.position(cell.column, cell.row);
        let mut further = 0;
        loop {
            let sideways = position.wrapping_add_signed(dx as isize);
            let upwards = position.wrapping_add_signed(stride);
            let next = sideways.wrapping_add_signed(stride);
            if !(free.at(sideways) && free.at(upwards) && free.at(next)) {
                return;
            }
            position = next;
            cell = Cell::new(cell.column + dx, cell.row + dy);
            further += DIAGONAL;
            if Node::new(cell) == self.goal {
                self.reach(self.goal, run.cost + further, one as Arrival, run.from);
                return;
            }
            self.run_straight(run, cell, further, one);
            self.run_straight(run, cell, further, other);
        }
    }

    #[inline]
    fn reach(&mut self, node: Node, cost: u64, arrival: Arrival, parent: Node) {
        let index = node.index(self.space.frame());
        if !self.labels.reach(index, cost, arrival, false) {
            return;
        }
        self.parents[index] = parent.bits();
        if node == self.goal {
            self.best = cost;
        }
        let estimate = cost + self.estimate(node.cell());
        if estimate < self.best {
            self.open.push(estimate, cost, node);
        }
    }

    #[inline]
    fn estimate(&self, cell: Cell) -> u64 {
        octile(cell, self.goal.cell())
    }
}

/// The end of a straight run.
struct Stop {
    /// Number of free cells passed, including the last.
    steps: i32,
    /// Whether a path may turn there; otherwise the next cell is blocked.
    may_turn: bool,
}

/// Scans a row of bits towards higher positions.
#[inline]
fn look_ahead(bits: &BitGrid, position: usize) -> Stop {
    let mut from = position;
    loop {
        let here = bits.window(from);
        let sides = [from + bits.stride(), from - bits.stride()].map(|side| bits.window(side));
        // Free cells whose predecessor is blocked.
        let [above, below] = sides.map(|side| side & !(side << 1));
        // The predecessor of the lowest bit is outside this window; that bit was the highest of the previous window.
        let stops = (above | below | !here) & !1;
        if stops != 0 {
            let bit = stops.trailing_zeros();
            return stop((from - position) as u32 + bit, here >> bit & 1 != 0);
        }
        from += 63;
    }
}

/// Scans a row of bits towards lower positions.
#[inline]
fn look_back(bits: &BitGrid, position: usize) -> Stop {
    const HIGHEST: u64 = 1 << 63;
    let mut from = position;
    loop {
        let here = bits.window(from - 63);
        let sides = [from + bits.stride(), from - bits.stride()].map(|side| bits.window(side - 63));
        let [above, below] = sides.map(|side| side & !(side >> 1));
        let stops = (above | below | !here) & !HIGHEST;
        if stops != 0 {
            let bit = stops.leading_zeros();
            return stop((position - from) as u32 + bit, here << bit & HIGHEST != 0);
        }
        from -= 63;
    }
}

#[inline]
fn stop(steps: u32, is_free: bool) -> Stop {
    Stop { steps: steps as i32 - i32::from(!is_free), may_turn: is_free }
}

/// Follows the parents from the goal back to the start and appends the cells. Each run is straight at its end and diagonal
/// before.
pub(super) fn trace_back(
    space: &FreeSpace,
    parents: &[u32],
    ends: (Node, Node),
    cells: &mut Vec<Cell>,
) {
    let (start, mut node) = ends;
    cells.push(node.cell());
    while node != start {
        let parent = Node::from_bits(parents[node.index(space.frame())]);
        let from = parent.cell();
        let mut cell = node.cell();
        while cell != from {
            let (dx, dy) = (from.column - cell.column, from.row - cell.row);
            // Straight while one axis has more cells left.
            let sideways = i32::from(dx.abs() >= dy.abs()) * dx.signum();
            let upwards = i32::from(dy.abs() >= dx.abs()) * dy.signum();
            cell = Cell::new(cell.column + sideways, cell.row + upwards);
            cells.push(cell);
        }
        node = parent;
    }
}
