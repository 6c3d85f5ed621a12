//! How global paths are made.

use serde::{Deserialize, Serialize};

use super::{Heuristic, PlanError};

/// How the grid is searched.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// A*, guided by [`Settings::heuristic`].
    #[default]
    AStar,
    /// Jump points: a shortest path whatever the heuristic set, in a fraction of the time.
    JumpPoints,
}

/// Settings of the global planner.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// How the grid is searched.
    pub search: Method,
    /// Estimate that guides A*.
    pub heuristic: Heuristic,
    /// Degree of the smoothing B-spline, 1 to 9; 1 leaves the pruned path as it is.
    pub spline_degree: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            search: Method::default(),
            heuristic: Heuristic::default(),
            spline_degree: 3,
        }
    }
}

impl Settings {
    /// Checks every number.
    ///
    /// # Errors
    /// Names the first that is out of range.
    pub fn validate(&self) -> Result<(), PlanError> {
        let degree = self.spline_degree;
        if !(1..=9).contains(&degree) {
            let (name, expected) = ("spline_degree", "1 to 9");
            return Err(PlanError::BadSetting {
                name,
                value: degree as f64,
                expected,
            });
        }
        let (name, value, is_good, expected) = match self.heuristic {
            Heuristic::Manhattan | Heuristic::Euclid | Heuristic::Octile => return Ok(()),
            Heuristic::Theta { degrees } => {
                let is_good = degrees > 0.0 && degrees <= 90.0;
                (
                    "heuristic.theta.degrees",
                    degrees,
                    is_good,
                    "above 0, at most 90",
                )
            }
            Heuristic::Normalized { k } => ("heuristic.normalized.k", k, is_weight(k), "0 to 1e6"),
            Heuristic::Additive { k } => ("heuristic.additive.k", k, is_weight(k), "0 to 1e6"),
            Heuristic::Literal { k } => ("heuristic.literal.k", k, is_weight(k), "0 to 1e6"),
        };
        if is_good {
            return Ok(());
        }
        Err(PlanError::BadSetting {
            name,
            value,
            expected,
        })
    }
}

fn is_weight(k: f64) -> bool {
    (0.0..=1e6).contains(&k)
}
