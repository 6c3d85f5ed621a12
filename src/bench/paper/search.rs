//! The searches that are compared.

use crate::global::{CellPath, Heuristic, NoPath, Searcher};
use crate::map::{Cell, FreeSpace};

/// A processing stage of a path; each stage includes those before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// As the search returns it.
    Raw,
    /// Without redundant nodes.
    Pruned,
    /// Smoothed.
    Smoothed,
}

/// Weight of [`Search::Literal`] in Tables 1 and 2. The paper prints no weight, so the formula has no factor.
pub const LITERAL_K: f64 = 1.0;
/// A weight for which the literal formula is nearly uninformed.
pub const SMALL_K: f64 = 0.001;

/// A search of the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Search {
    /// A* with the Manhattan distance: a traditional search.
    Manhattan,
    /// A* with the Euclidean distance: the other traditional search.
    Euclid,
    /// A* with a distance model of another angle, degrees (fig. 5).
    Theta(f64),
    /// A* with the paper's improved heuristic made scale-free: [`Heuristic::default`].
    Improved,
    /// A* with eq. 19 as printed, of this weight.
    Literal(f64),
    /// Jump points.
    JumpPoints,
}

impl Search {
    /// The heuristic; none for jump points.
    #[must_use]
    pub fn heuristic(self) -> Option<Heuristic> {
        Some(match self {
            Self::Manhattan => Heuristic::Manhattan,
            Self::Euclid => Heuristic::Euclid,
            Self::Theta(degrees) => Heuristic::Theta { degrees },
            Self::Improved => Heuristic::default(),
            Self::Literal(k) => Heuristic::Literal { k },
            Self::JumpPoints => return None,
        })
    }

    /// Whether its paths are always shortest ones on the grid.
    #[must_use]
    pub fn is_exact(self) -> bool {
        self.heuristic().is_none_or(|heuristic| heuristic.is_admissible())
    }

    /// Its last stage in this comparison: the baselines only search.
    #[must_use]
    pub fn last_stage(self) -> Stage {
        match self {
            Self::Improved | Self::JumpPoints => Stage::Smoothed,
            Self::Literal(k) if k == LITERAL_K => Stage::Smoothed,
            _ => Stage::Raw,
        }
    }

    /// The name in the records.
    #[must_use]
    pub fn name(self) -> String {
        match self {
            Self::Manhattan => "manhattan".to_owned(),
            Self::Euclid => "euclid".to_owned(),
            Self::Theta(degrees) => format!("theta_{degrees}"),
            Self::Improved => "improved".to_owned(),
            Self::Literal(k) => format!("literal_{k}"),
            Self::JumpPoints => "jump_points".to_owned(),
        }
    }

    /// The name in text for people.
    #[must_use]
    pub fn label(self) -> String {
        match self {
            Self::Manhattan => "Manhattan".to_owned(),
            Self::Euclid => "Euclid".to_owned(),
            Self::Theta(degrees) => format!("theta {degrees} degrees"),
            Self::Improved => "improved heuristic".to_owned(),
            Self::Literal(k) => format!("eq. 19 as printed, k = {k}"),
            Self::JumpPoints => "jump points".to_owned(),
        }
    }

    /// Runs the search.
    pub(super) fn run<'a>(
        self,
        searcher: &'a mut Searcher,
        space: &FreeSpace,
        start: Cell,
        goal: Cell,
    ) -> Result<CellPath<'a>, NoPath> {
        match self.heuristic() {
            Some(heuristic) => searcher.astar(space, start, goal, heuristic, None),
            None => searcher.jump_points(space, start, goal),
        }
    }
}
