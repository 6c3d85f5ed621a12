//! Settings of the global planner.

use serde::{Deserialize, Serialize};

use super::{ClearanceCosts, Heuristic, MAX_CLEARANCE_WEIGHT, PlanError};
use crate::documented::documented;
use crate::map::ObstacleGrid;

/// The search algorithm.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SearchMethod {
    /// A* with [`Settings::heuristic`].
    #[default]
    AStar,
    /// Jump point search: a shortest path, independent of the heuristic, in a fraction of the time.
    JumpPoints,
}

/// The nodes that pruning considers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Pruning {
    /// On long paths, the corners and some nodes between them: a nearly shortest chain in a tenth of the time.
    #[default]
    Sparse,
    /// All nodes: the shortest chain.
    Thorough,
}

documented! {
    /// Settings of the global planner.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct Settings {
        /// Search algorithm: `a_star`, guided by the heuristic, or `jump_points`, which finds a shortest path without heuristic in
        /// a fraction of the time.
        pub search: SearchMethod,
        /// Heuristic of A*: `"manhattan"`; `"euclid"` or `"octile"`, which give a shortest path; `{theta={degrees=30}}`, above 0
        /// and at most 90; the paper's eq. 19 as scale-free `{normalized={k=0.1}}`, not scale-free `{additive={k=0.01}}`, or as
        /// printed `{literal={k=0.01}}`, k from 0 to 1e6.
        pub heuristic: Heuristic,
        /// Additional cost of a path next to an obstacle, 0 to 15: with 1, a metre in contact costs as much as two metres of open
        /// space. 0 gives the shortest path. Only with A*.
        pub clearance_weight: f64,
        /// Clearance from which a path has no additional cost, metres, above zero and at most 1e6.
        pub preferred_clearance_m: f64,
        /// Nodes considered by pruning: `sparse`, the corners and some between, or `thorough`, all, for the shortest chain in
        /// ten times the time.
        pub pruning: Pruning,
        /// Degree of the smoothing B-spline, 1 to 9; 1 keeps the pruned path.
        pub spline_degree: usize,
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            search: SearchMethod::default(),
            heuristic: Heuristic::default(),
            clearance_weight: 0.0,
            preferred_clearance_m: 1.0,
            pruning: Pruning::default(),
            spline_degree: 3,
        }
    }
}

impl Settings {
    /// Whether the search finds an optimal path: shortest, or cheapest with costs.
    #[must_use]
    pub fn is_optimal(&self) -> bool {
        self.search == SearchMethod::JumpPoints || self.heuristic.is_admissible()
    }

    /// The clearance costs of these settings for a map; none if they request the shortest path.
    #[must_use]
    pub fn costs(&self, obstacles: &ObstacleGrid) -> Option<ClearanceCosts> {
        let Self {
            clearance_weight: weight,
            preferred_clearance_m,
            ..
        } = *self;
        (weight > 0.0).then(|| ClearanceCosts::new(obstacles, preferred_clearance_m, weight))
    }

    /// Validates all settings.
    ///
    /// # Errors
    /// Names the first setting that is out of range.
    pub fn validate(&self) -> Result<(), PlanError> {
        let weight = self.clearance_weight;
        let preferred_m = self.preferred_clearance_m;
        let only_shortest = self.search == SearchMethod::JumpPoints;
        check(
            "spline_degree",
            self.spline_degree as f64,
            (1..=9).contains(&self.spline_degree),
            "1 to 9",
        )?;
        check(
            "clearance_weight",
            weight,
            (0.0..=MAX_CLEARANCE_WEIGHT).contains(&weight),
            "0 to 15",
        )?;
        check(
            "clearance_weight",
            weight,
            weight == 0.0 || !only_shortest,
            "0 with search = \"jump_points\", which finds shortest paths only; \"a_star\" supports costs",
        )?;
        check(
            "preferred_clearance_m",
            preferred_m,
            preferred_m > 0.0 && preferred_m <= 1e6,
            "above 0, at most 1e6",
        )?;
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
        check(name, value, is_good, expected)
    }
}

fn check(
    name: &'static str,
    value: f64,
    is_good: bool,
    expected: &'static str,
) -> Result<(), PlanError> {
    if is_good {
        return Ok(());
    }
    Err(PlanError::BadSetting {
        name,
        value,
        expected,
    })
}

fn is_weight(k: f64) -> bool {
    (0.0..=1e6).contains(&k)
}
