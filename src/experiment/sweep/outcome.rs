//! What a cell gives.

use serde::{Deserialize, Serialize};

use crate::bench::LatencySummary;
use crate::experiment::barn::BarnRow;
use crate::experiment::dynabarn::{Culprit, DynaBarnRow};
use crate::experiment::missions::{Ending, Touch};
use crate::experiment::worlds::Verdict;
use crate::runtime::MissionResult;

/// How a cell ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CellResult {
    /// The robot reached its goal.
    Reached,
    /// It touched something, or was touched.
    Contact,
    /// The time was up.
    Timeout,
    /// The navigator gave up.
    Failed,
    /// It could not be begun: a start in a wall, a map without room.
    Error,
}

/// What came of a cell, by the simulated clock alone: the same bits on every machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// How it ended.
    pub result: CellResult,
    /// Whose a contact was: `robot`, `avoidable` or `other`; none without contact.
    pub contact: Option<String>,
    /// Simulated time, seconds.
    pub time_s: f64,
    /// Way driven, metres.
    pub travelled_m: f64,
    /// Smallest true gap on the way, metres; none where no tick was driven.
    pub min_clearance_m: Option<f64>,
    /// Time that BARN's own path takes at 2 m/s, seconds; none elsewhere.
    pub optimal_time_s: Option<f64>,
    /// BARN's score, 0 to 0.5; none elsewhere.
    pub score: Option<f64>,
    /// Global plans.
    pub plans: u64,
    /// Ticks.
    pub ticks: u64,
    /// Digest of the trace; none where no tick was driven.
    pub trace_digest: Option<String>,
    /// Why the goal was not reached; none where it was.
    pub reason: Option<String>,
}

/// What the wall clock said of a latency cell: a tick of the navigator from the scan to the command.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CellLatency {
    /// Threads of a CPU engine.
    pub threads: usize,
    /// Ticks timed.
    pub ticks: u64,
    /// Median, milliseconds.
    pub tick_p50_ms: f64,
    /// 95th percentile, milliseconds.
    pub tick_p95_ms: f64,
    /// 99th percentile, milliseconds.
    pub tick_p99_ms: f64,
    /// Slowest, milliseconds.
    pub tick_max_ms: f64,
    /// The engine, with its threads and instructions, or its adapter.
    pub ran_on: String,
    /// The machine.
    pub machine: String,
}

impl CellLatency {
    pub(super) fn new(
        times: LatencySummary,
        threads: usize,
        ran_on: String,
        machine: &str,
    ) -> Self {
        Self {
            threads,
            ticks: times.count,
            tick_p50_ms: times.p50_ms,
            tick_p95_ms: times.p95_ms,
            tick_p99_ms: times.p99_ms,
            tick_max_ms: times.max_ms,
            ran_on,
            machine: machine.to_owned(),
        }
    }
}

impl Outcome {
    /// Of a cell that could not be begun.
    pub(super) const fn error(reason: String) -> Self {
        Self {
            result: CellResult::Error,
            contact: None,
            time_s: 0.0,
            travelled_m: 0.0,
            min_clearance_m: None,
            optimal_time_s: None,
            score: None,
            plans: 0,
            ticks: 0,
            trace_digest: None,
            reason: Some(reason),
        }
    }

    /// Of a run of BARN.
    pub(super) fn barn(row: BarnRow, result: Option<&MissionResult>) -> Self {
        let contact = (row.result == Verdict::Collided).then(|| "robot".to_owned());
        Self {
            optimal_time_s: Some(row.optimal_time_s),
            score: Some(row.score),
            ..Self::driven(row.result.into(), contact, row.fault, result)
        }
    }

    /// Of a run of `DynaBARN`.
    pub(super) fn dynabarn(row: DynaBarnRow, result: Option<&MissionResult>) -> Self {
        let contact = match row.blame {
            Culprit::Robot => Some("robot"),
            Culprit::Avoidable => Some("avoidable"),
            Culprit::Other => Some("other"),
            Culprit::Nobody => None,
        };
        let contact = contact.map(str::to_owned);
        Self::driven(row.result.into(), contact, row.fault, result)
    }

    /// Of a mission.
    pub(super) fn mission(
        ending: Ending,
        touch: Touch,
        reason: Option<String>,
        result: Option<&MissionResult>,
    ) -> Self {
        let contact = match touch {
            Touch::Robot => Some("robot"),
            Touch::Other => Some("other"),
            Touch::None => None,
        };
        let contact = contact.map(str::to_owned);
        Self::driven(ending.into(), contact, reason, result)
    }

    fn driven(
        ended: CellResult,
        contact: Option<String>,
        reason: Option<String>,
        result: Option<&MissionResult>,
    ) -> Self {
        let plain = Self {
            result: ended,
            contact,
            reason,
            ..Self::error(String::new())
        };
        let Some(result) = result else {
            return plain;
        };
        Self {
            time_s: result.time_s,
            travelled_m: result.travelled_m,
            min_clearance_m: Some(result.min_clearance_m).filter(|gap_m| gap_m.is_finite()),
            plans: result.plans.len() as u64,
            ticks: result.trace.rows.len() as u64,
            trace_digest: Some(result.trace.digest()),
            ..plain
        }
    }
}

impl From<Verdict> for CellResult {
    fn from(verdict: Verdict) -> Self {
        match verdict {
            Verdict::Succeeded => Self::Reached,
            Verdict::Collided => Self::Contact,
            Verdict::Timeout => Self::Timeout,
            Verdict::Failed => Self::Failed,
        }
    }
}

impl From<Ending> for CellResult {
    fn from(ending: Ending) -> Self {
        match ending {
            Ending::Reached => Self::Reached,
            Ending::Failed => Self::Failed,
            Ending::Contact => Self::Contact,
            Ending::Timeout => Self::Timeout,
        }
    }
}
