//! Settings of the global planner.

use serde::{Deserialize, Serialize};
use serde_json::json;

use super::{ClearanceCosts, Heuristic};
use crate::map::ObstacleGrid;
use crate::settings::{SettingError, choices, range, require, setting_schema, settings};

/// The search algorithm.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
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
#[non_exhaustive]
pub enum Pruning {
    /// On long paths, the corners and some nodes between them: a nearly shortest chain in a tenth of the time.
    #[default]
    Sparse,
    /// All nodes: the shortest chain.
    Thorough,
}

settings! {
    /// Settings of the global planner.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct Settings {
        /// Search algorithm: `a_star`, guided by the heuristic, or `jump_points`, which finds a shortest path without
        /// heuristic in a fraction of the time.
        pub search: SearchMethod = SearchMethod::default();
        /// Heuristic of A*: `"manhattan"`; `"euclid"` or `"octile"`, which give a shortest path;
        /// `{theta={degrees=30}}`, above 0 and at most 90; the paper's eq. 19 as scale-free `{normalized={k=0.1}}`,
        /// not scale-free `{additive={k=0.01}}`, or as printed `{literal={k=0.01}}`, k from 0 to 1e6.
        pub heuristic: Heuristic = Heuristic::default();
        /// Additional cost of a path next to an obstacle: with 1, a metre in contact costs as much as two of open
        /// space. 0 gives the shortest path. Only with A*.
        pub clearance_weight: f64 = 0.0, ["", 0 to 15];
        /// Clearance from which a path has no additional cost.
        pub preferred_clearance_m: f64 = 1.0, ["m", above 0 to 1e6];
        /// Nodes considered by pruning: `sparse`, the corners and some between, or `thorough`, all, for the shortest
        /// chain in ten times the time.
        pub pruning: Pruning = Pruning::default();
        /// Degree of the smoothing B-spline; 1 keeps the pruned path.
        pub spline_degree: usize = 3, ["", 1 to 9];
    }
    rule |settings| settings.check_rules()
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
        let Self { clearance_weight: weight, preferred_clearance_m, .. } = *self;
        (weight > 0.0).then(|| ClearanceCosts::new(obstacles, preferred_clearance_m, weight))
    }

    /// Checks the rules between the keys, and the number of the heuristic.
    fn check_rules(&self) -> Result<(), SettingError> {
        require(
            self.clearance_weight == 0.0 || self.search != SearchMethod::JumpPoints,
            "clearance_weight",
            self.clearance_weight,
            "0 with search = \"jump_points\", which finds shortest paths only; \"a_star\" supports costs",
        )?;
        let (name, value, range) = match self.heuristic {
            Heuristic::Manhattan | Heuristic::Euclid | Heuristic::Octile => return Ok(()),
            Heuristic::Theta { degrees } => {
                ("heuristic.theta.degrees", degrees, range!(above 0 to 90))
            }
            Heuristic::Normalized { k } => ("heuristic.normalized.k", k, range!(0 to 1e6)),
            Heuristic::Additive { k } => ("heuristic.additive.k", k, range!(0 to 1e6)),
            Heuristic::Literal { k } => ("heuristic.literal.k", k, range!(0 to 1e6)),
        };
        require(range.contains(value), name, value, range.text)
    }
}

setting_schema! {
    SearchMethod: choices::<Self>();
    Pruning: choices::<Self>();
    Heuristic: json!({ "type": ["string", "object"] });
}
