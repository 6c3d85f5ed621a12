//! What is left to the goal, estimated: the traditional heuristics and the paper's improved ones (eqs. 14-19).

use serde::{Deserialize, Serialize};

use super::cost::{DIAGONAL, STRAIGHT};
use crate::map::Cell;

/// How the search estimates the cost from a cell to the goal.
///
/// Costs are in 1/[`STRAIGHT`] of a cell. A heuristic is admissible, and the path found the shortest, when it never
/// exceeds the true cost on an 8-connected grid with diagonals of sqrt 2.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Heuristic {
    /// `dx + dy` (eq. 14). Not admissible where diagonals are allowed.
    Manhattan,
    /// Straight-line distance to the goal (eq. 15, which prints the start). Admissible.
    Euclid,
    /// Distance on an empty grid (eqs. 16 and 17). Admissible, and exact on open ground.
    Octile,
    /// Octile distance plus `k` times the distance from the start-goal line, in cells: eq. 19 made scale-free by
    /// dividing the cross product of eq. 18 by the line's length. Not admissible for `k` above zero; paths are at most a
    /// few tenths of a percent longer on average at the default of 0.1.
    Normalized {
        /// Weight of the distance from the line, at least zero.
        k: f64,
    },
    /// Octile distance plus `k` times the cross product of eq. 18, in cells squared. Not admissible for `k` above zero.
    Additive {
        /// Weight of the cross product, at least zero.
        k: f64,
    },
    /// Octile distance times the cross product times `k`: eq. 19 as printed. Zero on the whole start-goal line and
    /// cubic off it, so neither informed nor admissible; kept to re-run the paper's own claim.
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
    /// Whether it never exceeds the true cost.
    #[must_use]
    pub fn is_admissible(&self) -> bool {
        match *self {
            Self::Euclid | Self::Octile => true,
            Self::Manhattan | Self::Literal { .. } => false,
            Self::Normalized { k } | Self::Additive { k } => k == 0.0,
        }
    }

    /// The weight `k`, for the modes that have one.
    #[must_use]
    pub const fn weight(&self) -> Option<f64> {
        match *self {
            Self::Manhattan | Self::Euclid | Self::Octile => None,
            Self::Normalized { k } | Self::Additive { k } | Self::Literal { k } => Some(k),
        }
    }

    /// The estimate for one query.
    pub(super) fn estimator(self, start: Cell, goal: Cell) -> Estimator {
        Estimator {
            heuristic: self,
            start,
            goal,
        }
    }
}

/// A heuristic with its start and goal.
pub(super) struct Estimator {
    heuristic: Heuristic,
    start: Cell,
    goal: Cell,
}

/// Estimates stop here, so that a path's cost and an estimate always add up.
const MOST: f64 = 1e15;

impl Estimator {
    /// Estimated cost from a cell to the goal, rounded down.
    pub fn cost(&self, cell: Cell) -> u64 {
        let dx = (cell.column - self.goal.column).unsigned_abs();
        let dy = (cell.row - self.goal.row).unsigned_abs();
        let octile =
            u64::from(dx.max(dy) - dx.min(dy)) * STRAIGHT + u64::from(dx.min(dy)) * DIAGONAL;
        let scaled = |cells: f64| (cells * STRAIGHT as f64).min(MOST) as u64;
        match self.heuristic {
            Heuristic::Manhattan => u64::from(dx + dy) * STRAIGHT,
            Heuristic::Euclid => scaled((f64::from(dx).powi(2) + f64::from(dy).powi(2)).sqrt()),
            Heuristic::Octile => octile,
            Heuristic::Normalized { k } => {
                octile + scaled(k * self.cross(cell) / self.line_length())
            }
            Heuristic::Additive { k } => octile + scaled(k * self.cross(cell)),
            Heuristic::Literal { k } => {
                scaled(octile as f64 / STRAIGHT as f64 * self.cross(cell) * k)
            }
        }
    }

    /// Eq. 18: twice the area of the triangle of cell, start and goal, in cells squared.
    fn cross(&self, cell: Cell) -> f64 {
        let (dx1, dy1) = difference(cell, self.goal);
        let (dx2, dy2) = difference(self.start, self.goal);
        (dx1 * dy2 - dx2 * dy1).abs()
    }

    fn line_length(&self) -> f64 {
        let (dx, dy) = difference(self.start, self.goal);
        (dx * dx + dy * dy).sqrt().max(1.0)
    }
}

fn difference(from: Cell, to: Cell) -> (f64, f64) {
    (
        f64::from(from.column - to.column),
        f64::from(from.row - to.row),
    )
}
