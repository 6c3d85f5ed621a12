//! The measured search algorithms.

use crate::bench::search_grid;
use crate::global::{CellPath, Heuristic, NoPath, Searcher};
use crate::map::{Cell, FreeSpace};

/// A search from start to goal with reused memory. It gets the algorithm's heuristic.
pub type Search = for<'a> fn(
    &'a mut Searcher,
    &FreeSpace,
    [Cell; 2],
    Option<Heuristic>,
) -> Result<CellPath<'a>, NoPath>;

/// A search algorithm.
#[derive(Clone, Copy, Debug)]
pub struct Algorithm {
    /// Its name, without a comma.
    pub name: &'static str,
    /// Whether it is measured by default.
    pub usual: bool,
    /// The heuristic of A*; none for jump points.
    pub heuristic: Option<Heuristic>,
    /// Searches from start to goal.
    pub search: Search,
}

impl Algorithm {
    /// Whether each of its paths must be the shortest.
    #[must_use]
    pub fn is_exact(&self) -> bool {
        self.heuristic.is_none_or(|heuristic| heuristic.is_admissible())
    }
}

/// All algorithms: name, whether it is measured by default, and its heuristic.
pub const ALGORITHMS: [Algorithm; 11] = [
    row("Dijkstra", false, Some(Heuristic::Literal { k: 0.0 })),
    row("A* Euclid", false, Some(Heuristic::Euclid)),
    row("A* octile", true, Some(Heuristic::Octile)),
    row("jump points", true, None),
    row("A* theta 30", false, Some(Heuristic::Theta { degrees: 30.0 })),
    row("A* theta 45", false, Some(Heuristic::Theta { degrees: 45.0 })),
    row("A* normalized 0.1", true, Some(Heuristic::Normalized { k: 0.1 })),
    row("A* Manhattan", false, Some(Heuristic::Manhattan)),
    row("A* theta 60", false, Some(Heuristic::Theta { degrees: 60.0 })),
    row("A* additive 0.001", false, Some(Heuristic::Additive { k: 0.001 })),
    row("A* literal 0.001", false, Some(Heuristic::Literal { k: 0.001 })),
];

const fn row(name: &'static str, usual: bool, heuristic: Option<Heuristic>) -> Algorithm {
    Algorithm { name, usual, heuristic, search: search_grid }
}
