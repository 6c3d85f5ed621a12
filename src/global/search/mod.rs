//! The cheapest path over free cells, by A* or by jump points, in memory that is used again and again.

mod astar;
mod jump;
mod labels;
mod moves;
mod node;
mod open_list;

use astar::{Outcome, search};
use jump::Jumps;
use labels::Labels;
use node::Node;
use open_list::{Buckets, Sorted};

use super::ClearanceCosts;
use super::cost::{DIAGONAL, octile};
use super::heuristic::Heuristic;
use crate::map::{Cell, FreeSpace};

/// A path of cells and what it took to find it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CellPath<'a> {
    /// Start to goal, both included; each cell is a neighbour of the one before.
    pub cells: &'a [Cell],
    /// Cost of the moves between them, in the units of [`STRAIGHT`](super::STRAIGHT).
    pub cost: u64,
    /// Times that a cell was taken off the open list and expanded; the goal is not.
    pub expanded: u32,
}

/// A search that found nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoPath {
    /// Times that a cell was expanded. A* has then expanded all that can be reached from the start.
    pub expanded: u32,
}

/// Searches grids, one query after the other, without asking for memory once it has seen a grid as large and a query as
/// hard. It keeps 12 bytes a cell of the largest grid, 8 of them where no query was by jump points, and the open list.
///
/// Moves go to the eight neighbours; a diagonal one needs both cells beside it free. What a query returns depends on
/// nothing but the query.
#[derive(Clone, Debug, Default)]
pub struct Searcher {
    labels: Labels,
    parents: Vec<u32>,
    buckets: Buckets,
    sorted: Sorted,
    cells: Vec<Cell>,
}

impl Searcher {
    /// The cheapest path over free cells from start to goal, by A*.
    ///
    /// With an admissible heuristic it is a shortest one: every such heuristic here is consistent. [`Heuristic::Octile`] has
    /// the fastest open list. The others keep to the textbook: cells are expanded by their estimates, of equal ones first
    /// the cell that cost more to reach, and none twice.
    ///
    /// With `costs`, cheapest means by them instead of by length.
    ///
    /// # Errors
    /// [`NoPath`] when no path joins the two, as when one of them is not free or lies outside the grid.
    ///
    /// # Panics
    /// When the costs are of a smaller grid.
    pub fn astar(
        &mut self,
        space: &FreeSpace,
        start: Cell,
        goal: Cell,
        heuristic: Heuristic,
        costs: Option<&ClearanceCosts>,
    ) -> Result<CellPath<'_>, NoPath> {
        let ends = self.begin(space, start, goal)?;
        let Self {
            labels,
            buckets,
            sorted,
            ..
        } = self;
        let same = |_, cost| cost;
        let estimator = heuristic.estimator(start, goal);
        let estimate = |cell| estimator.cost(cell);
        sorted.begin();
        let outcome = match (heuristic, costs) {
            (Heuristic::Octile, None) => {
                let estimate = |cell| octile(cell, goal);
                buckets.begin(estimate(start), 2 * DIAGONAL);
                search(space, ends, labels, buckets, estimate, same)
            }
            (_, None) => search(space, ends, labels, sorted, estimate, same),
            (_, Some(costs)) => {
                let price = |index, cost| costs.price(index, cost);
                search(space, ends, labels, sorted, estimate, price)
            }
        };
        self.finish(&outcome, |work, cells| {
            astar::trace_back(space, &work.labels, ends.1, cells);
        })
    }

    /// A shortest path over free cells from start to goal, by jump points: exactly as long as that of [`Self::astar`] with an
    /// admissible heuristic, and many times sooner found where there is open ground or long walls.
    ///
    /// # Errors
    /// As [`Self::astar`].
    pub fn jump_points(
        &mut self,
        space: &FreeSpace,
        start: Cell,
        goal: Cell,
    ) -> Result<CellPath<'_>, NoPath> {
        let ends = self.begin(space, start, goal)?;
        let frame = space.frame();
        if self.parents.len() < frame.len() {
            self.parents = vec![0; frame.len()];
        }
        // A run leads at most along the grid's sides, and straight away from the goal.
        let longest = (frame.width as u64 + frame.height as u64) * 2 * DIAGONAL;
        self.buckets.begin(octile(start, goal), longest);
        let outcome = Jumps {
            space,
            goal: ends.1,
            labels: &mut self.labels,
            open: &mut self.buckets,
            parents: &mut self.parents,
            best: u64::MAX,
        }
        .search(ends.0);
        self.finish(&outcome, |work, cells| {
            jump::trace_back(space, &work.parents, ends, cells);
        })
    }

    /// Clears all for a query; its ends, when both are free.
    fn begin(
        &mut self,
        space: &FreeSpace,
        start: Cell,
        goal: Cell,
    ) -> Result<(Node, Node), NoPath> {
        self.cells.clear();
        if !(space.is_free(start) && space.is_free(goal)) {
            return Err(NoPath { expanded: 0 });
        }
        self.labels.begin(space.frame().len());
        Ok((Node::new(start), Node::new(goal)))
    }

    fn finish(
        &mut self,
        outcome: &Outcome,
        trace_back: impl FnOnce(&Self, &mut Vec<Cell>),
    ) -> Result<CellPath<'_>, NoPath> {
        let expanded = outcome.expanded;
        let cost = outcome.cost.ok_or(NoPath { expanded })?;
        let mut cells = core::mem::take(&mut self.cells);
        trace_back(self, &mut cells);
        cells.reverse();
        self.cells = cells;
        Ok(CellPath {
            cells: &self.cells,
            cost,
            expanded,
        })
    }
}
