//! Validity and length of a path, from the obstacles alone.

use core::f64::consts::SQRT_2;

use thiserror::Error;

use crate::map::{Cell, ObstacleGrid};

/// Why a path is invalid. Cells are (column, row) from the lower left.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
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
        let (found, expected) = (first, start);
        return Err(IllegalPath::OtherStart { found, expected });
    }
    if last != goal {
        let (found, expected) = (last, goal);
        return Err(IllegalPath::OtherGoal { found, expected });
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
