//! Check of an answer against the published length.

use super::legality::{IllegalPath, path_length};
use crate::map::{Cell, ObstacleGrid, Scenario, cell_from_top_left};

/// Largest error of a listed length in addition to its rounding, cells: the benchmark's authors summed in single precision.
pub const TOLERANCE: f64 = 2e-4;

/// Result of the check of an answer.
#[derive(Clone, Copy, Debug, PartialEq)]
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
