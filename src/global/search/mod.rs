//! Grid search for the cheapest path over free cells, by A* or jump points, with reusable memory.

mod astar;
mod jump;
mod labels;
mod moves;
mod open_list;

use astar::{Outcome, search};
use jump::Jumps;
use labels::Labels;
use moves::Node;
use open_list::{Buckets, Sorted};

use super::ClearanceCosts;
use super::heuristic::{DIAGONAL, Heuristic, octile};
use crate::map::{Cell, FreeSpace};

/// A path of cells, with cost and effort.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CellPath<'a> {
    /// Start to goal, both included; adjacent cells are neighbours.
    pub cells: &'a [Cell],
    /// Total cost of the moves, in units of [`STRAIGHT`](super::STRAIGHT).
    pub cost: u64,
    /// Number of cell expansions; the goal is not expanded.
    pub expanded: u32,
}

/// A search without a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoPath {
    /// Number of cell expansions. A* has then expanded all cells reachable from the start.
    pub expanded: u32,
}

/// A grid search with reusable memory: no allocation once it has searched a grid as large and a query as hard. It keeps 12
/// bytes per cell of the largest grid (8 without jump point queries), and the open list.
///
/// Moves go to the eight neighbours; a diagonal move needs both adjacent cells free. The result depends on the query only.
#[derive(Clone, Debug, Default)]
pub struct Searcher {
    labels: Labels,
    parents: Vec<u32>,
    buckets: Buckets,
    sorted: Sorted,
    cells: Vec<Cell>,
}

impl Searcher {
    /// Finds the cheapest path over free cells from start to goal by A*.
    ///
    /// With an admissible heuristic the path is a shortest one; all admissible heuristics here are consistent.
    /// [`Heuristic::Octile`] uses the fastest open list. The others use the textbook order: cells are expanded by estimate,
    /// ties by higher cost so far, and each cell once.
    ///
    /// With `costs`, the path minimises them instead of the length.
    ///
    /// # Errors
    /// Returns [`NoPath`] if no path connects the ends, also if one of them is not free or outside the grid.
    ///
    /// # Panics
    /// Panics if the costs belong to a smaller grid.
    pub fn astar(
        &mut self,
        space: &FreeSpace,
        start: Cell,
        goal: Cell,
        heuristic: Heuristic,
        costs: Option<&ClearanceCosts>,
    ) -> Result<CellPath<'_>, NoPath> {
        let ends = self.begin(space, start, goal)?;
        let Self { labels, buckets, sorted, .. } = self;
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

    /// Finds a shortest path over free cells from start to goal by jump point search. It is exactly as long as that of
    /// [`Self::astar`] with an admissible heuristic, and found many times faster in open space or along straight walls.
    ///
    /// # Errors
    /// See [`Self::astar`].
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
        // A run is at most as long as both sides of the grid, and may lead away from the goal.
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

    /// Clears the memory for a query and returns its ends, if both are free.
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
        Ok(CellPath { cells: &self.cells, cost, expanded })
    }
}
