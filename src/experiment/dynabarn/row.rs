//! What a run leaves behind.

use serde::{Deserialize, Serialize};

use super::Blame;
use crate::bench::Columns;
use crate::experiment::campaign::Row;
use crate::experiment::worlds::{RunKey, Verdict};

/// Whose a contact was.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Culprit {
    /// The robot's, which was closing the gap by its own motion, or touched what does not move.
    Robot,
    /// The robot's as well: it was run into, and in hindsight could have stayed clear.
    Avoidable,
    /// Nobody's here: it was run into, and no command that was tried would have kept it clear.
    Other,
    /// There was no contact.
    #[serde(rename = "-")]
    Nobody,
}

impl From<Blame> for Culprit {
    fn from(blame: Blame) -> Self {
        if blame.by_robot {
            Self::Robot
        } else if blame.avoidable {
            Self::Avoidable
        } else {
            Self::Other
        }
    }
}

/// One run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DynaBarnRow {
    /// The world's number.
    pub world: u32,
    /// Seed of the noise.
    pub seed: u64,
    /// How it ended.
    pub result: Verdict,
    /// Whose the contact was that ended it.
    pub blame: Culprit,
    /// Simulated time, seconds.
    pub time_s: f64,
    /// Way driven, metres.
    pub travelled_m: f64,
    /// Smallest true gap on the way, metres; none where no tick was driven.
    pub min_clearance_m: Option<f64>,
    /// Global plans.
    pub plans: u64,
    /// Why the navigator gave up, where it did.
    pub fault: Option<String>,
    /// Wall-clock time of a decision, the median, milliseconds.
    pub decision_p50_ms: Option<f64>,
    /// The same, the 99th percentile.
    pub decision_p99_ms: Option<f64>,
}

impl Columns for DynaBarnRow {
    const COLUMNS: &[&str] = &[
        "world",
        "seed",
        "result",
        "blame",
        "time_s",
        "travelled_m",
        "min_clearance_m",
        "plans",
        "fault",
        "decision_p50_ms",
        "decision_p99_ms",
    ];
}

impl Row for DynaBarnRow {
    type Key = RunKey;

    fn key(&self) -> RunKey {
        RunKey {
            world: self.world,
            seed: self.seed,
        }
    }
}
