//! Heuristics of the A* search: the traditional ones and the paper's improved ones (eqs. 14-19).

use serde::{Deserialize, Serialize};

use crate::map::Cell;

/// Cost of a move to one of the four nearest cells.
pub const STRAIGHT: u64 = 13_860;

/// Cost of a diagonal move. 19601/13860 is sqrt 2 within 2e-9, so that integer sums order paths by length.
pub const DIAGONAL: u64 = 19_601;

/// Cost of the shortest path between two cells without obstacles (eqs. 16 and 17).
#[inline]
pub(super) fn octile(one: Cell, other: Cell) -> u64 {
    let dx = one.column.abs_diff(other.column);
    let dy = one.row.abs_diff(other.row);
    u64::from(dx.max(dy)) * STRAIGHT + u64::from(dx.min(dy)) * (DIAGONAL - STRAIGHT)
}

/// The estimate of the cost from a cell to the goal.
///
/// Costs are in 1/[`STRAIGHT`] of a cell. A heuristic is admissible, and the search finds a shortest path, if it never
/// exceeds the true cost on an 8-connected grid with diagonals of sqrt 2.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[non_exhaustive]
pub enum Heuristic {
    /// `dx + dy` (eq. 14). Not admissible with diagonal moves.
    Manhattan,
    /// Straight-line distance to the goal (eq. 15, which prints the start). Admissible.
    Euclid,
    /// Distance on an empty grid (eqs. 16 and 17). Admissible, and exact without obstacles.
    Octile,
    /// Leaves the axis at an angle to run straight to the goal (section 3.2.1 and fig. 5, without a formula):
    /// `d_min / sin a + d_max - d_min / tan a`, equal to `d_max + d_min tan(a / 2)`. At 45 degrees it equals
    /// [`Self::Octile`], at 90 [`Self::Manhattan`]. Admissible up to 45.
    Theta {
        /// The angle, above 0 and at most 90.
        degrees: f64,
    },
    /// Octile distance plus `k` times the distance from the start-goal line, in cells: eq. 19 with the cross product of eq. 18
    /// divided by the line's length, which makes it scale-free. Not admissible for `k` above zero; at the default of 0.1,
    /// paths are at most a few tenths of a percent longer on average.
    Normalized {
        /// Weight of the distance from the line, at least zero.
        k: f64,
    },
    /// Octile distance plus `k` times the cross product of eq. 18, in cells squared. Not admissible for `k` above zero.
    Additive {
        /// Weight of the cross product, at least zero.
        k: f64,
    },
    /// Octile distance times the cross product times `k`: eq. 19 as printed. It is zero on the whole start-goal line and cubic
    /// elsewhere, so it is neither informed nor admissible. Used to reproduce the paper's results.
    Literal {
        /// Weight of the product, at least zero.
        k: f64,
    },
}

impl Default for Heuristic {
    fn default() -> Self {
        Self::Normalized { k: 0.1 }
    }
}

impl Heuristic {
    /// Whether the heuristic never exceeds the true cost.
    #[must_use]
    pub fn is_admissible(&self) -> bool {
        match *self {
            Self::Euclid | Self::Octile => true,
            Self::Theta { degrees } => degrees <= 45.0,
            Self::Manhattan => false,
            Self::Normalized { k } | Self::Additive { k } | Self::Literal { k } => k == 0.0,
        }
    }

    /// Creates the estimator of the costs from cells to the goal of one query.
    #[must_use]
    pub fn estimator(self, start: Cell, goal: Cell) -> Estimator {
        let (dx, dy) = difference(start, goal);
        let sideways = match self {
            Self::Theta { degrees } => libm::tan(degrees.to_radians() / 2.0),
            _ => 0.0,
        };
        Estimator {
            heuristic: self,
            goal,
            line: (dx, dy),
            line_length: (dx * dx + dy * dy).sqrt().max(1.0),
            sideways,
        }
    }
}

/// A heuristic with start and goal.
#[derive(Clone, Debug)]
pub struct Estimator {
    heuristic: Heuristic,
    goal: Cell,
    /// From the goal to the start, in cells.
    line: (f64, f64),
    /// Length of that line, at least one.
    line_length: f64,
    /// Cost of a lateral cell in addition to a straight one, for [`Heuristic::Theta`].
    sideways: f64,
}

/// Largest estimate, so that the sum with a path's cost does not overflow.
const MAX_ESTIMATE: f64 = 1e14;

impl Estimator {
    /// Estimated cost from a cell of the grid to the goal, rounded down.
    #[must_use]
    pub fn cost(&self, cell: Cell) -> u64 {
        let dx = (cell.column - self.goal.column).unsigned_abs();
        let dy = (cell.row - self.goal.row).unsigned_abs();
        let (least, most) = (dx.min(dy), dx.max(dy));
        let octile = octile(cell, self.goal);
        let scaled = |cells: f64| (cells * STRAIGHT as f64).min(MAX_ESTIMATE) as u64;
        match self.heuristic {
            Heuristic::Manhattan => u64::from(dx + dy) * STRAIGHT,
            Heuristic::Euclid => scaled((f64::from(dx).powi(2) + f64::from(dy).powi(2)).sqrt()),
            Heuristic::Octile => octile,
            Heuristic::Theta { .. } => scaled(f64::from(most) + f64::from(least) * self.sideways),
            Heuristic::Normalized { k } => octile + scaled(k * self.cross(cell) / self.line_length),
            Heuristic::Additive { k } => octile + scaled(k * self.cross(cell)),
            Heuristic::Literal { k } => {
                scaled(octile as f64 / STRAIGHT as f64 * self.cross(cell) * k)
            }
        }
    }

    /// Eq. 18: twice the area of the triangle of cell, start and goal, in cells squared.
    fn cross(&self, cell: Cell) -> f64 {
        let (dx1, dy1) = difference(cell, self.goal);
        let (dx2, dy2) = self.line;
        (dx1 * dy2 - dx2 * dy1).abs()
    }
}

fn difference(from: Cell, to: Cell) -> (f64, f64) {
    (f64::from(from.column - to.column), f64::from(from.row - to.row))
}
