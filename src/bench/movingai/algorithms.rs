//! The measured search algorithms.

use crate::global::{CellPath, Heuristic, NoPath, Searcher};
use crate::map::{Cell, FreeSpace};

/// The answer of a search to a query.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Answer<'a> {
    /// Cells from start to goal, both included, each a neighbour of the previous one; none when no path was found.
    pub cells: Option<&'a [Cell]>,
    /// Number of cell expansions.
    pub expanded: u32,
}

impl<'a> From<Result<CellPath<'a>, NoPath>> for Answer<'a> {
    fn from(outcome: Result<CellPath<'a>, NoPath>) -> Self {
        match outcome {
            Ok(found) => Self { cells: Some(found.cells), expanded: found.expanded },
            Err(not_found) => Self { cells: None, expanded: not_found.expanded },
        }
    }
}

/// A search from start to goal with reused memory.
pub type Search = for<'a> fn(&'a mut Searcher, &FreeSpace, Cell, Cell) -> Answer<'a>;

/// A search algorithm.
#[derive(Clone, Copy, Debug)]
pub struct Algorithm {
    /// Its name, without a comma.
    pub name: &'static str,
    /// Whether each of its paths must be the shortest.
    pub exact: bool,
    /// Whether it is measured by default.
    pub usual: bool,
    /// Searches from start to goal.
    pub search: Search,
}

/// All algorithms: name, exactness, whether it is measured by default, and its search.
pub const ALGORITHMS: [Algorithm; 11] = [
    row("Dijkstra", true, false, |searcher, space, start, goal| {
        searcher.astar(space, start, goal, Heuristic::Literal { k: 0.0 }, None).into()
    }),
    row("A* Euclid", true, false, |searcher, space, start, goal| {
        searcher.astar(space, start, goal, Heuristic::Euclid, None).into()
    }),
    row("A* octile", true, true, |searcher, space, start, goal| {
        searcher.astar(space, start, goal, Heuristic::Octile, None).into()
    }),
    row("jump points", true, true, |searcher, space, start, goal| {
        searcher.jump_points(space, start, goal).into()
    }),
    row("A* theta 30", true, false, |searcher, space, start, goal| {
        searcher.astar(space, start, goal, Heuristic::Theta { degrees: 30.0 }, None).into()
    }),
    row("A* theta 45", true, false, |searcher, space, start, goal| {
        searcher.astar(space, start, goal, Heuristic::Theta { degrees: 45.0 }, None).into()
    }),
    row("A* normalized 0.1", false, true, |searcher, space, start, goal| {
        searcher.astar(space, start, goal, Heuristic::Normalized { k: 0.1 }, None).into()
    }),
    row("A* Manhattan", false, false, |searcher, space, start, goal| {
        searcher.astar(space, start, goal, Heuristic::Manhattan, None).into()
    }),
    row("A* theta 60", false, false, |searcher, space, start, goal| {
        searcher.astar(space, start, goal, Heuristic::Theta { degrees: 60.0 }, None).into()
    }),
    row("A* additive 0.001", false, false, |searcher, space, start, goal| {
        searcher.astar(space, start, goal, Heuristic::Additive { k: 0.001 }, None).into()
    }),
    row("A* literal 0.001", false, false, |searcher, space, start, goal| {
        searcher.astar(space, start, goal, Heuristic::Literal { k: 0.001 }, None).into()
    }),
];

const fn row(name: &'static str, exact: bool, usual: bool, search: Search) -> Algorithm {
    Algorithm { name, exact, usual, search }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn algorithm_names_are_unique_and_fit_a_table() {
        for (index, algorithm) in ALGORITHMS.iter().enumerate() {
            assert!(!algorithm.name.contains([',', '"']), "{}", algorithm.name);
            let others = &ALGORITHMS[index + 1..];
            assert!(others.iter().all(|other| other.name != algorithm.name));
        }
        let usual =
            |exact| ALGORITHMS.iter().any(|algorithm| algorithm.usual && algorithm.exact == exact);
        assert!(usual(true) && usual(false));
    }

    #[test]
    fn default_heuristic_is_measured_by_default() {
        assert_eq!(Heuristic::default(), Heuristic::Normalized { k: 0.1 });
    }
}
