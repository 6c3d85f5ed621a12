//! What an answer is worth beside the published length.

use super::legality::{IllegalPath, path_length};
use crate::map::{Cell, ObstacleGrid, Scenario, cell_from_top_left};

/// The most that a listed length is off beside its rounding, cells: the benchmark's makers added up in single precision.
pub const TOLERANCE: f64 = 2e-4;

/// What an answer is worth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
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
    /// A path that may not be walked.
    Illegal(IllegalPath),
    /// No path, though one exists.
    NotFound,
}

impl Verdict {
    /// What is wrong, for the messages of an exact algorithm or one that need not be; none where nothing is.
    #[must_use]
    pub fn fault(&self, exact: bool, listed: f64) -> Option<String> {
        match self {
            Self::Optimal => None,
            Self::Longer { length } => exact
                .then(|| format!("the path is {length:.6} long, longer than the {listed} listed")),
            Self::Shorter { length } => Some(format!(
                "the path is {length:.6} long, shorter than the {listed} listed"
            )),
            Self::Illegal(why) => Some(why.to_string()),
            Self::NotFound => Some("no path was found".to_owned()),
        }
    }
}

/// Judges an answer to a scenario: the cells of the path, or none where it found none. A length counts as the listed one
/// within [`TOLERANCE`] and what the file's digits cannot tell ([`Scenario::rounding`]).
#[must_use]
pub fn judge(obstacles: &ObstacleGrid, scenario: &Scenario, cells: Option<&[Cell]>) -> Verdict {
    let Some(cells) = cells else {
        return Verdict::NotFound;
    };
    let [start, goal] =
        [scenario.start, scenario.goal].map(|end| cell_from_top_left(obstacles.frame(), end));
    match path_length(obstacles, start, goal, cells) {
        Err(why) => Verdict::Illegal(why),
        Ok(length) => {
            let tolerance = TOLERANCE + scenario.rounding;
            if length > scenario.optimal + tolerance {
                Verdict::Longer { length }
            } else if length < scenario.optimal - tolerance {
                Verdict::Shorter { length }
            } else {
                Verdict::Optimal
            }
        }
    }
}
