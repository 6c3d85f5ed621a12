//! What a run leaves behind.

use core::fmt::{self, Display};

use serde::{Deserialize, Serialize};

use crate::bench::campaign::Row;
use crate::sim::MissionResult;

/// How a run ended, in the challenge's words and one more.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The true pose came within 1 m of the goal.
    Succeeded,
    /// The robot touched something.
    Collided,
    /// The time was up.
    Timeout,
    /// The navigator gave up, with a reason.
    Failed,
}

impl Verdict {
    /// Of a mission that was driven.
    #[must_use]
    pub const fn of(result: &MissionResult) -> Self {
        // Contact comes first: a robot that touches something within the goal's radius did not get there.
        if result.collided {
            Self::Collided
        } else if result.reached {
            Self::Succeeded
        } else if result.fault.is_some() {
            Self::Failed
        } else {
            Self::Timeout
        }
    }
}

/// Which run: the world, and the seed of its noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct RunKey {
    /// The world's number.
    pub world: u32,
    /// The seed.
    pub seed: u64,
}

impl Display for RunKey {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "world {}, seed {}", self.world, self.seed)
    }
}

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

impl Row for BarnRow {
    type Key = RunKey;

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

    fn key(&self) -> RunKey {
        RunKey {
            world: self.world,
            seed: self.seed,
        }
    }
}
