//! What a run leaves behind.

use serde::{Deserialize, Serialize};

use crate::bench::Columns;
use crate::experiment::campaign::Row;
use crate::experiment::worlds::{RunKey, Verdict};

/// One run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BarnRow {
    /// The world's number.
    pub world: u32,
    /// Seed of the noise.
    pub seed: u64,
    /// How it ended.
    pub result: Verdict,
    /// Simulated time, seconds.
    pub time_s: f64,
    /// Way driven, metres.
    pub travelled_m: f64,
    /// Smallest true gap on the way, metres; none where no tick was driven.
    pub min_clearance_m: Option<f64>,
    /// Time that the benchmark's path takes at 2 m/s, seconds.
    pub optimal_time_s: f64,
    /// Score, 0 to 0.5.
    pub score: f64,
    /// Why the navigator gave up, where it did.
    pub fault: Option<String>,
    /// Wall-clock time of a decision, the median, milliseconds.
    pub decision_p50_ms: Option<f64>,
    /// The same, the 99th percentile.
    pub decision_p99_ms: Option<f64>,
}

impl Columns for BarnRow {
    const COLUMNS: &[&str] = &[
        "world",
        "seed",
        "result",
        "time_s",
        "travelled_m",
        "min_clearance_m",
        "optimal_time_s",
        "score",
        "fault",
        "decision_p50_ms",
        "decision_p99_ms",
    ];
}

impl Row for BarnRow {
    type Key = RunKey;

    fn key(&self) -> RunKey {
        RunKey {
            world: self.world,
            seed: self.seed,
        }
    }
}
