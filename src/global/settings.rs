//! How global paths are made.

use serde::{Deserialize, Serialize};

use super::{ClearanceCosts, Heuristic, MAX_CLEARANCE_WEIGHT, PlanError};
use crate::documented::documented;
use crate::map::ObstacleGrid;

/// How the grid is searched.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SearchMethod {
    /// A*, guided by [`Settings::heuristic`].
    #[default]
    AStar,
    /// Jump points: a shortest path whatever the heuristic set, in a fraction of the time.
    JumpPoints,
}

/// Which nodes of a path take part in the removal of the redundant ones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Pruning {
    /// Of a long path the corners, and a few between: near to the shortest chain, in a tenth of the time.
    #[default]
    Sparse,
    /// All: the shortest chain.
    Thorough,
}

documented! {
    /// Settings of the global planner.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct Settings {
        /// How the grid is searched: `a_star`, guided by the heuristic, or `jump_points`, a shortest path whatever the
        /// heuristic in a fraction of the time.
        pub search: SearchMethod,
        /// Estimate that guides A*: `"manhattan"`; `"euclid"` or `"octile"`, which find a shortest path;
        /// `{theta={degrees=30}}`, above 0 and at most 90; the paper's eq. 19 made scale-free, `{normalized={k=0.1}}`, not
        /// made so, `{additive={k=0.01}}`, or as printed, `{literal={k=0.01}}`, k from 0 to 1e6.
        pub heuristic: Heuristic,
        /// How much dearer than open ground a path along a wall is, 0 to 15: with 1, a metre that touches it costs as much as two
        /// of open ground. 0 asks for the shortest path. Takes effect with A* only.
        pub clearance_weight: f64,
        /// The distance to the nearest obstacle from which ground counts as open, metres, above zero and at most 1e6.
        pub preferred_clearance_m: f64,
        /// Which nodes of a path take part in the removal of the redundant ones: `sparse`, the corners and a few between,
        /// or `thorough`, all, for the shortest chain in ten times the time.
        pub pruning: Pruning,
        /// Degree of the smoothing B-spline, 1 to 9; 1 leaves the pruned path as it is.
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
    /// Whether the path searched is a shortest one through cells, or by costs a cheapest one.
    #[must_use]
    pub fn is_optimal(&self) -> bool {
        self.search == SearchMethod::JumpPoints || self.heuristic.is_admissible()
    }

    /// The costs that these settings ask for among obstacles; none when they ask for the shortest path.
    #[must_use]
    pub fn costs(&self, obstacles: &ObstacleGrid) -> Option<ClearanceCosts> {
        let Self {
            clearance_weight: weight,
            preferred_clearance_m,
            ..
        } = *self;
        (weight > 0.0).then(|| ClearanceCosts::new(obstacles, preferred_clearance_m, weight))
    }

    /// Checks every number.
    ///
    /// # Errors
    /// Names the first that is out of range.
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
            "0 with search = \"jump_points\", which finds shortest paths only; \"a_star\" knows costs",
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
