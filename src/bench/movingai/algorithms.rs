//! What is measured: the one list of search algorithms.

use crate::global::{Found, Heuristic, NotFound, astar};
use crate::map::{Cell, FreeSpace};

/// What a search says of a query.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Answer {
    /// Start to goal, both included, each cell beside the one before; none when no path was found.
    pub cells: Option<Vec<Cell>>,
    /// Cells expanded.
    pub expanded: u32,
}

impl From<Result<Found, NotFound>> for Answer {
    fn from(outcome: Result<Found, NotFound>) -> Self {
        match outcome {
            Ok(found) => Self {
                cells: Some(found.cells),
                expanded: found.expanded,
            },
            Err(not_found) => Self {
                cells: None,
                expanded: not_found.expanded,
            },
        }
    }
}

/// A way to search.
#[derive(Clone, Copy, Debug)]
pub struct Algorithm {
    /// Its name, without a comma.
    pub name: &'static str,
    /// Whether each of its paths must be the shortest.
    pub exact: bool,
    /// Whether it is measured unless others are asked for.
    pub usual: bool,
    /// Searches from start to goal.
    pub search: fn(&FreeSpace, Cell, Cell) -> Answer,
}

/// All algorithms: name, whether it is exact, whether it is measured unless all are asked for, how it searches.
pub const ALGORITHMS: [Algorithm; 10] = [
    row("Dijkstra", true, false, |space, start, goal| {
        by(space, start, goal, Heuristic::Literal { k: 0.0 })
    }),
    row("A* Euclid", true, false, |space, start, goal| {
        by(space, start, goal, Heuristic::Euclid)
    }),
    row("A* octile", true, true, |space, start, goal| {
        by(space, start, goal, Heuristic::Octile)
    }),
    row("A* theta 30", true, false, |space, start, goal| {
        by(space, start, goal, Heuristic::Theta { degrees: 30.0 })
    }),
    row("A* theta 45", true, false, |space, start, goal| {
        by(space, start, goal, Heuristic::Theta { degrees: 45.0 })
    }),
    row("A* normalized 0.1", false, true, |space, start, goal| {
        by(space, start, goal, Heuristic::Normalized { k: 0.1 })
    }),
    row("A* Manhattan", false, false, |space, start, goal| {
        by(space, start, goal, Heuristic::Manhattan)
    }),
    row("A* theta 60", false, false, |space, start, goal| {
        by(space, start, goal, Heuristic::Theta { degrees: 60.0 })
    }),
    row("A* additive 0.001", false, false, |space, start, goal| {
        by(space, start, goal, Heuristic::Additive { k: 0.001 })
    }),
    row("A* literal 0.001", false, false, |space, start, goal| {
        by(space, start, goal, Heuristic::Literal { k: 0.001 })
    }),
];

const fn row(
    name: &'static str,
    exact: bool,
    usual: bool,
    search: fn(&FreeSpace, Cell, Cell) -> Answer,
) -> Algorithm {
    Algorithm {
        name,
        exact,
        usual,
        search,
    }
}

fn by(space: &FreeSpace, start: Cell, goal: Cell, heuristic: Heuristic) -> Answer {
    astar(space, start, goal, heuristic).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_fit_a_table_and_tell_the_algorithms_apart() {
        for (index, algorithm) in ALGORITHMS.iter().enumerate() {
            assert!(!algorithm.name.contains([',', '"']), "{}", algorithm.name);
            let others = &ALGORITHMS[index + 1..];
            assert!(others.iter().all(|other| other.name != algorithm.name));
        }
        let usual = |exact| {
            ALGORITHMS
                .iter()
                .any(|algorithm| algorithm.usual && algorithm.exact == exact)
        };
        assert!(usual(true) && usual(false));
    }

    #[test]
    fn the_default_heuristic_is_measured_unasked() {
        assert_eq!(Heuristic::default(), Heuristic::Normalized { k: 0.1 });
    }
}
