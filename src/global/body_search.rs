//! The search over cells and headings on the whole map. It finds the way around a narrow passage through which the discs of a body
//! pass, and the body does not.

use core::iter::once;

use super::body_moves::{BodyMoves, HEADINGS, States};
use super::{BodySpace, ClearanceCosts, Path, STRAIGHT};
use crate::geometry::Point;
use crate::map::Cell;

/// In open ground the body takes only each fifth move ahead: to the eight neighbours. These reach all cells that the longer moves do.
const NEIGHBOUR_HEADINGS: usize = 5;

/// A search by A*. A cell in which the body may have any heading is one state, so the memory and time for open ground are those of a
/// search without headings.
pub(super) struct BodySearch<'a> {
    body: &'a BodySpace<'a>,
    moves: BodyMoves<'a>,
    /// First state of each cell, plus one; zero for a cell without states.
    first_states: Vec<u32>,
    /// Cell of each state.
    cells: Vec<Cell>,
    states: States,
    goal: Point,
}

impl<'a> BodySearch<'a> {
    pub fn new(body: &'a BodySpace<'a>, costs: &'a ClearanceCosts) -> Self {
        Self {
            body,
            moves: BodyMoves::new(body, costs),
            first_states: vec![0; body.narrow.frame().len()],
            cells: Vec::new(),
            states: States::new(0),
            goal: Point::default(),
        }
    }

    /// The cheapest path, where turns in cells with any heading cost nothing. Without a path: the centre of the reached cell nearest to
    /// the goal; ties go to the first in storage order.
    pub fn path(mut self, start: &Point, goal: &Point) -> Result<Path, Option<Point>> {
        let frame = *self.body.narrow.frame();
        let first = frame.cell_of(start).ok_or(None)?;
        self.goal = frame.to_cell_units(goal);
        let headings: Vec<usize> = self.moves.fitting(first).collect();
        for heading in headings {
            let state = self.state(first, heading);
            self.reach(state, 0, None);
        }
        let last = frame.cell_of(goal);
        let mut nearest: Option<(f64, usize)> = None;
        while let Some((state, cost)) = self.states.next() {
            let cell = self.cells[state];
            if Some(cell) == last {
                return Ok(self.trace_back(state, start, goal));
            }
            let found = ((cell.center() - self.goal).norm_squared(), frame.index(cell));
            if nearest.is_none_or(|nearest| found < nearest) {
                nearest = Some(found);
            }
            self.expand(state, cost);
        }
        Err(nearest.map(|(_, index)| frame.center_of(frame.cell_at(index))))
    }

    fn expand(&mut self, state: usize, cost: u64) {
        let cell = self.cells[state];
        if self.has_any_heading(cell) {
            for heading in 0..HEADINGS {
                let is_needed = heading.is_multiple_of(NEIGHBOUR_HEADINGS)
                    || !BodyMoves::cells_ahead(cell, heading)
                        .all(|cell| self.has_any_heading(cell));
                if is_needed {
                    self.drive(state, heading, cost);
                }
            }
            return;
        }
        let heading = state - self.state(cell, 0);
        for next in BodyMoves::turns(heading) {
            let (next_state, cost) = (self.state(cell, next), cost + self.moves.turn_cost(cell));
            if self.states.is_better(next_state, cost)
                && self.moves.fits_turning(cell, heading, next)
            {
                self.reach(next_state, cost, Some(state));
            }
        }
        self.drive(state, heading, cost);
    }

    /// Drives ahead from a state.
    fn drive(&mut self, state: usize, heading: usize, cost: u64) {
        let cell = self.cells[state];
        let next = BodyMoves::ahead(cell, heading);
        if !self.body.narrow.is_free(next) {
            return;
        }
        let cost = cost + self.moves.ahead_cost(next, heading);
        let next_state = self.state(next, heading);
        if self.states.is_better(next_state, cost) && self.moves.fits_ahead(cell, heading) {
            self.reach(next_state, cost, Some(state));
        }
    }

    fn has_any_heading(&self, cell: Cell) -> bool {
        self.body.wide.is_free(cell)
    }

    /// The state of a cell and a heading; a cell gets its states when it is asked for the first time.
    fn state(&mut self, cell: Cell, heading: usize) -> usize {
        let count = if self.has_any_heading(cell) { 1 } else { HEADINGS };
        let first = &mut self.first_states[self.body.narrow.frame().index(cell)];
        if *first == 0 {
            *first = self.cells.len() as u32 + 1;
            self.cells.resize(self.cells.len() + count, cell);
            self.states.grow(count);
        }
        *first as usize - 1 + heading % count
    }

    fn reach(&mut self, state: usize, cost: u64, before: Option<usize>) {
        // No way is shorter than the straight line.
        let left = (self.cells[state].center() - self.goal).norm() * STRAIGHT as f64;
        self.states.reach(state, cost, left as u64, before);
    }

    fn trace_back(&self, state: usize, start: &Point, goal: &Point) -> Path {
        let frame = self.body.narrow.frame();
        let mut cells: Vec<Cell> =
            self.states.trace_back(state).map(|state| self.cells[state]).collect();
        cells.dedup();
        // From the centre of an end's cell to the end, the body would head somewhere else.
        let between = cells.get(1..cells.len() - 1).unwrap_or_default();
        let centers = between.iter().rev().map(|&cell| frame.center_of(cell));
        Path::new(once(*start).chain(centers).chain(once(*goal)).collect())
    }
}
