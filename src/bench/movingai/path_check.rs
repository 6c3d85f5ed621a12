//! Check of an answer against the published length: validity and length of its path, from the obstacles alone.

use core::f64::consts::SQRT_2;

use thiserror::Error;

use crate::map::{Cell, ObstacleGrid, Scenario, cell_from_top_left};

/// Why a path is invalid. Cells are (column, row) from the lower left.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum IllegalPath {
    /// It has no cell.
    #[error("the path has no cell")]
    Empty,
    /// It begins at another cell.
    #[error("the path begins at ({}, {}), not at the start ({}, {})", found.column, found.row, expected.column, expected.row)]
    OtherStart {
        /// Its first cell.
        found: Cell,
        /// The start.
        expected: Cell,
    },
    /// It ends at another cell.
    #[error("the path ends at ({}, {}), not at the goal ({}, {})", found.column, found.row, expected.column, expected.row)]
    OtherGoal {
        /// Its last cell.
        found: Cell,
        /// The goal.
        expected: Cell,
    },
    /// One of its cells is an obstacle or outside the map.
    #[error("the path is blocked at ({}, {})", cell.column, cell.row)]
    Blocked {
        /// The cell.
        cell: Cell,
    },
    /// Two consecutive cells that are no neighbours.
    #[error("the path jumps from ({}, {}) to ({}, {})", from.column, from.row, to.column, to.row)]
    Jump {
        /// The first cell.
        from: Cell,
        /// The next cell.
        to: Cell,
    },
    /// A diagonal move past an obstacle.
    #[error("the path cuts the corner between ({}, {}) and ({}, {})", from.column, from.row, to.column, to.row)]
    CutCorner {
        /// From this cell.
        from: Cell,
        /// To this cell.
        to: Cell,
    },
}

/// The length of a path in cells: one for a straight move, sqrt 2 for a diagonal one.
///
/// # Errors
/// Fails when it does not lead from start to goal by moves to one of the eight neighbours, over free cells only, each
/// diagonal move between two free cells.
#[doc(hidden)]
pub fn path_length(
    obstacles: &ObstacleGrid,
    start: Cell,
    goal: Cell,
    cells: &[Cell],
) -> Result<f64, IllegalPath> {
    let (Some(&first), Some(&last)) = (cells.first(), cells.last()) else {
        return Err(IllegalPath::Empty);
    };
    if first != start {
        return Err(IllegalPath::OtherStart { found: first, expected: start });
    }
    if last != goal {
        return Err(IllegalPath::OtherGoal { found: last, expected: goal });
    }
    if let Some(&cell) = cells.iter().find(|&&cell| obstacles.is_blocked(cell)) {
        return Err(IllegalPath::Blocked { cell });
    }
    let (mut straight, mut diagonal) = (0_u32, 0_u32);
    for pair in cells.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        match (from.column.abs_diff(to.column), from.row.abs_diff(to.row)) {
            (1, 0) | (0, 1) => straight += 1,
            (1, 1) => {
                let corners = [Cell::new(from.column, to.row), Cell::new(to.column, from.row)];
                if corners.iter().any(|&cell| obstacles.is_blocked(cell)) {
                    return Err(IllegalPath::CutCorner { from, to });
                }
                diagonal += 1;
            }
            _ => return Err(IllegalPath::Jump { from, to }),
        }
    }
    Ok(f64::from(straight) + f64::from(diagonal) * SQRT_2)
}

/// Largest error of a listed length in addition to its rounding, cells: the benchmark's authors summed in single precision.
pub const TOLERANCE: f64 = 2e-4;

/// Result of the check of an answer.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum AnswerCheck {
    /// A legal path of the listed length.
    Optimal,
    /// A legal path that is longer.
    Longer {
        /// Its length, cells.
        length: f64,
    },
    /// A legal path that is shorter: one of the two lengths is wrong.
    Shorter {
        /// Its length, cells.
        length: f64,
    },
    /// An invalid path.
    Illegal(IllegalPath),
    /// No path, though one exists.
    NotFound,
}

impl AnswerCheck {
    /// The fault of an answer for messages, none for a correct one; `exact` algorithms must find shortest paths.
    #[must_use]
    pub fn fault(&self, exact: bool, listed: f64) -> Option<String> {
        match self {
            Self::Optimal => None,
            Self::Longer { length } => exact
                .then(|| format!("the path is {length:.6} long, longer than the {listed} listed")),
            Self::Shorter { length } => {
                Some(format!("the path is {length:.6} long, shorter than the {listed} listed"))
            }
            Self::Illegal(why) => Some(why.to_string()),
            Self::NotFound => Some("no path was found".to_owned()),
        }
    }
}

/// Checks an answer to a scenario: the cells of the path, or none if the search found none. A length equals the listed
/// one within [`TOLERANCE`] and the rounding of the file ([`Scenario::rounding`]).
#[must_use]
pub fn check_answer(
    obstacles: &ObstacleGrid,
    scenario: &Scenario,
    cells: Option<&[Cell]>,
) -> AnswerCheck {
    let Some(cells) = cells else {
        return AnswerCheck::NotFound;
    };
    let [start, goal] =
        [scenario.start, scenario.goal].map(|end| cell_from_top_left(obstacles.frame(), end));
    match path_length(obstacles, start, goal, cells) {
        Err(why) => AnswerCheck::Illegal(why),
        Ok(length) => {
            let tolerance = TOLERANCE + scenario.rounding;
            if length > scenario.optimal + tolerance {
                AnswerCheck::Longer { length }
            } else if length < scenario.optimal - tolerance {
                AnswerCheck::Shorter { length }
            } else {
                AnswerCheck::Optimal
            }
        }
    }
}
