//! Rows of the measurement.

use serde::{Deserialize, Serialize};

use crate::bench::columns::columns;

columns! {
    /// One algorithm on the scenarios of a map, or of all maps together.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    pub struct AlgorithmRow {
        /// Name of the map; `all` for all maps together.
        pub map: String,
        /// Its name.
        pub name: String,
        /// Whether each of its paths must be the shortest.
        pub exact: bool,
        /// Scenarios answered by a valid path that is not shorter than listed.
        pub solved: usize,
        /// Scenarios.
        pub total: usize,
        /// Scenarios solved by a path longer than listed.
        pub suboptimal: usize,
        /// Scenarios answered by an invalid path or by one that is shorter than listed.
        pub illegal: usize,
        /// Median time of a query, microseconds.
        pub median_us: f64 => 1,
        /// 95th percentile, microseconds.
        pub p95_us: f64 => 1,
        /// Slowest, microseconds.
        pub max_us: f64 => 1,
        /// Cells expanded in a query, the mean.
        pub expanded: f64 => 0,
        /// Length of a path over the one listed, the mean over the scenarios solved; those of length zero are left out. Null
        /// where none is left.
        pub mean_length_ratio: Option<f64> => 5,
        /// The same, the greatest.
        pub worst_length_ratio: Option<f64> => 5,
        /// The first wrong answer: map, line of the scenario, fault.
        pub first_fault: Option<String>,
    }
}

impl AlgorithmRow {
    /// Whether every answer was correct: solved, and for an exact algorithm also shortest.
    #[must_use]
    pub fn passed(&self) -> bool {
        self.solved == self.total && self.illegal == 0 && !(self.exact && self.suboptimal > 0)
    }
}

/// All algorithms on the scenarios of a map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MapRows {
    /// Name of the map.
    pub map: String,
    /// Scenarios.
    pub scenarios: usize,
    /// A row for each algorithm.
    pub algorithms: Vec<AlgorithmRow>,
}
