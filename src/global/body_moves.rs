//! The moves of a body that is longer than wide, over cells and headings: ahead, or to the next heading on the spot.

use core::cmp::Reverse;
use core::iter::successors;
use std::collections::BinaryHeap;

use super::{BodySpace, ClearanceCosts, STRAIGHT};
use crate::geometry::Point;
use crate::map::{Cell, GridFrame};

/// Moves ahead at each heading, cells. The headings are those of the moves; each quarter turn repeats the first ten. Most walls lie along
/// the axes, and a body that turns away from the wall beside it has room for a few degrees only.
const AHEAD: [(i32, i32); 40] = {
    let mut moves = [(0, 0); 40];
    let first = [(1, 0), (8, 1), (4, 1), (2, 1), (4, 3), (1, 1), (3, 4), (1, 2), (1, 4), (1, 8)];
    let mut heading = 0;
    while heading < moves.len() {
        moves[heading] = if heading < first.len() {
            first[heading]
        } else {
            let (dx, dy) = moves[heading - first.len()];
            (-dy, dx)
        };
        heading += 1;
    }
    moves
};
pub(super) const HEADINGS: usize = AHEAD.len();
/// A turn to the next heading costs as much as this distance, metres.
const TURN_M: f64 = 0.05;

/// The moves of a body, their costs, and where it fits on them.
pub(super) struct BodyMoves<'a> {
    body: &'a BodySpace<'a>,
    costs: &'a ClearanceCosts,
    frame: GridFrame,
    /// The headings, radians.
    yaws: [f64; HEADINGS],
    /// Cost of a turn to the next heading where there is no additional cost.
    turn: u64,
}

impl<'a> BodyMoves<'a> {
    pub fn new(body: &'a BodySpace<'a>, costs: &'a ClearanceCosts) -> Self {
        let frame = *body.narrow.frame();
        let yaws =
            AHEAD.map(|(dx, dy)| libm::atan2(f64::from(dy), f64::from(dx)) + frame.origin.yaw);
        let turn = (TURN_M / frame.resolution_m * STRAIGHT as f64) as u64;
        Self { body, costs, frame, yaws, turn }
    }

    /// The headings with which the body fits at the centre of a cell.
    pub fn fitting(&self, cell: Cell) -> impl Iterator<Item = usize> + '_ {
        let center = self.center(cell);
        (0..HEADINGS).filter(move |&heading| self.body.fits_at(&center, self.yaws[heading]))
    }

    /// The headings next to a heading.
    pub const fn turns(heading: usize) -> [usize; 2] {
        [(heading + 1) % HEADINGS, (heading + HEADINGS - 1) % HEADINGS]
    }

    /// Cost of a turn to the next heading at a cell.
    pub fn turn_cost(&self, cell: Cell) -> u64 {
        self.costs.price(self.frame.index(cell), self.turn)
    }

    pub fn fits_turning(&self, cell: Cell, heading: usize, next: usize) -> bool {
        self.body.fits_turning(&self.center(cell), self.yaws[heading], self.yaws[next])
    }

    /// The cell to which the move ahead leads; it may be outside the grid.
    pub const fn ahead(cell: Cell, heading: usize) -> Cell {
        let (dx, dy) = AHEAD[heading];
        Cell::new(cell.column + dx, cell.row + dy)
    }

    /// The cells next to the line of the move ahead, each one a neighbour of the one before it.
    pub fn cells_ahead(cell: Cell, heading: usize) -> impl Iterator<Item = Cell> {
        let (dx, dy) = AHEAD[heading];
        let steps = dx.abs().max(dy.abs());
        let at = move |whole: i32, step: i32| {
            (f64::from(whole * step) / f64::from(steps)).round() as i32
        };
        (1..=steps).map(move |step| Cell::new(cell.column + at(dx, step), cell.row + at(dy, step)))
    }

    /// Cost of the move ahead to a cell of the grid.
    pub fn ahead_cost(&self, next: Cell, heading: usize) -> u64 {
        let (dx, dy) = AHEAD[heading];
        let length = f64::from(dx * dx + dy * dy).sqrt() * STRAIGHT as f64;
        self.costs.price(self.frame.index(next), length as u64)
    }

    pub fn fits_ahead(&self, cell: Cell, heading: usize) -> bool {
        let next = self.center(Self::ahead(cell, heading));
        self.body.fits_ahead(&self.center(cell), &next, self.yaws[heading])
    }

    fn center(&self, cell: Cell) -> Point {
        self.frame.center_of(cell)
    }
}

/// Costs and predecessors of the states of the search.
pub(super) struct States {
    costs: Vec<u64>,
    /// The state before each one, plus one; zero for the first.
    before: Vec<u32>,
    open: BinaryHeap<Reverse<(u64, u64, u32)>>,
}

impl States {
    pub fn new(count: usize) -> Self {
        Self { costs: vec![u64::MAX; count], before: vec![0; count], open: BinaryHeap::new() }
    }

    pub fn is_better(&self, state: usize, cost: u64) -> bool {
        cost < self.costs[state]
    }

    pub fn reach(&mut self, state: usize, cost: u64, left: u64, before: Option<usize>) {
        self.costs[state] = cost;
        self.before[state] = before.map_or(0, |before| before as u32 + 1);
        self.open.push(Reverse((cost + left, cost, state as u32)));
    }

    /// The open state with the least estimate, and its cost.
    pub fn next(&mut self) -> Option<(usize, u64)> {
        while let Some(Reverse((_, cost, state))) = self.open.pop() {
            if self.costs[state as usize] == cost {
                return Some((state as usize, cost));
            }
        }
        None
    }

    pub fn before(&self, state: usize) -> Option<usize> {
        (self.before[state] as usize).checked_sub(1)
    }

    /// A state, the state before it, and so on until the first one.
    pub fn trace_back(&self, state: usize) -> impl Iterator<Item = usize> + '_ {
        successors(Some(state), |&state| self.before(state))
    }

    /// Adds states that are not reached yet.
    pub fn grow(&mut self, count: usize) {
        self.costs.resize(self.costs.len() + count, u64::MAX);
        self.before.resize(self.before.len() + count, 0);
    }
}
