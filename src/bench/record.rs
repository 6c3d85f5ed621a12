//! What a measurement leaves behind.

use serde::{Deserialize, Serialize};

/// One cell of `bench density`: one engine at one sampling density.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DensityRow {
    /// `cpu` or `gpu`.
    pub engine: String,
    /// The adapter's name, for a GPU engine.
    pub adapter: Option<String>,
    /// Threads of a CPU engine; zero for a GPU engine.
    pub threads: usize,
    /// Samples of the dynamic window.
    pub samples: usize,
    /// Steps of the horizon.
    pub steps: usize,
    /// Median time of one decision, end to end, milliseconds.
    pub p50_ms: f64,
    /// 95th percentile, milliseconds.
    pub p95_ms: f64,
    /// 99th percentile, milliseconds.
    pub p99_ms: f64,
    /// Slowest, milliseconds.
    pub max_ms: f64,
    /// Decisions timed.
    pub decisions: usize,
    /// Trajectory-steps per second at the median.
    pub steps_per_s: f64,
}
