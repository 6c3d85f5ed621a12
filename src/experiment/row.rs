//! One row for each run, for all kinds of worlds.

use serde::{Deserialize, Serialize};

use super::{CellId, TrafficKind, WorldKind};
use crate::bench::columns::{column_values, columns};
use crate::bench::{Latencies, LatencySummary};
use crate::runtime::MissionResult;

/// How a run ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RunOutcome {
    /// The robot reached its goal.
    Reached,
    /// The robot and something touched.
    Contact,
    /// The time was up.
    Timeout,
    /// The navigator gave up.
    Failed,
    /// The run did not start: a start in a wall, a map without room.
    #[default]
    Error,
}

impl RunOutcome {
    /// As people read it.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::Reached => "reached its goal",
            Self::Contact => "touched something",
            Self::Timeout => "ran out of time",
            Self::Failed => "gave up",
            Self::Error => "did not start",
        }
    }
}

/// The body whose motion caused a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ContactCause {
    /// The robot closed the gap by its own motion, or touched what does not move.
    Robot,
    /// An obstacle closed the gap, and in hindsight the robot had a command that keeps clear.
    Avoidable,
    /// An obstacle closed the gap, and no command tried keeps clear.
    Other,
}

column_values! {
    Text: RunOutcome, ContactCause, WorldKind, TrafficKind;
}

columns! {
    /// One run: its cell, how it ended, and its figures. Only the fields from `ran_on` on depend on the machine.
    #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
    #[serde(default)]
    pub struct RunRow {
        /// Kind of the world.
        pub kind: WorldKind,
        /// Name or number of the world.
        pub world: String,
        /// Name of the settings; none where the plan has only one.
        pub config: Option<String>,
        /// Name of the weights; none where the plan has none.
        pub weights: Option<String>,
        /// Forward speeds of the dynamic window.
        pub vx_samples: u32,
        /// Turn rates of the dynamic window.
        pub vtheta_samples: u32,
        /// The engine, as the plan names it.
        pub engine: String,
        /// Seed of noise and moving obstacles.
        pub seed: u64,
        /// Whether the cell measures latency and so has the machine to itself.
        pub latency: bool,
        /// How the run ended.
        pub outcome: RunOutcome,
        /// Whose motion caused the contact; none without contact.
        pub contact_cause: Option<ContactCause>,
        /// Nav2's name of the navigator's fault; none where it did not give up.
        pub fault: Option<String>,
        /// Why the goal was not reached, a sentence; none where it was.
        pub reason: Option<String>,
        /// Simulated time, seconds.
        pub time_s: f64 => 2,
        /// Length of a mission's first global path, metres; none elsewhere.
        pub path_m: Option<f64> => 2,
        /// Distance driven, metres.
        pub travelled_m: f64 => 2,
        /// Smallest true gap during the run, metres; none where no tick was driven.
        pub min_clearance_m: Option<f64> => 3,
        /// True distance from the goal at the end, metres; none where no tick was driven.
        pub final_error_m: Option<f64> => 4,
        /// True yaw minus the goal's at the end, radians, -pi to pi; none without a goal yaw.
        pub final_yaw_error_rad: Option<f64> => 4,
        /// Time that BARN's own path takes at 2 m/s, seconds; none elsewhere.
        pub optimal_time_s: Option<f64> => 2,
        /// BARN's score, 0 to 0.5; none elsewhere.
        pub score: Option<f64> => 4,
        /// Kind of a mission's moving obstacles; none elsewhere.
        pub traffic: Option<TrafficKind>,
        /// Number of moving obstacles.
        pub obstacles: usize,
        /// Number of obstacles on the path that the map does not show.
        pub unmapped: usize,
        /// Number of global plans.
        pub plans: usize,
        /// Number of ticks.
        pub ticks: usize,
        /// Digest of the trace; none where no tick was driven.
        pub trace_digest: Option<String>,
        /// The cell's key; empty for a run outside a plan.
        pub key: String,
        /// The engine with its threads and instructions, or its adapter.
        pub ran_on: Option<String>,
        /// The machine; none where latency is not measured.
        pub machine: Option<String>,
        /// Threads of the CPU engine; none where latency is not measured.
        pub threads: Option<usize>,
        /// Wall-clock time of a tick, from the scan to the command, the median, milliseconds.
        pub tick_p50_ms: Option<f64> => 3,
        /// The same, the 95th percentile.
        pub tick_p95_ms: Option<f64> => 3,
        /// The same, the 99th percentile.
        pub tick_p99_ms: Option<f64> => 3,
        /// The same, the slowest.
        pub tick_max_ms: Option<f64> => 3,
    }
}

impl RunRow {
    /// The row with the names of a cell.
    #[must_use]
    pub fn named(self, id: &CellId, key: &str) -> Self {
        let id = id.clone();
        Self {
            kind: id.kind,
            world: id.world,
            config: id.config,
            weights: id.weights,
            vx_samples: id.vx_samples,
            vtheta_samples: id.vtheta_samples,
            engine: id.engine,
            seed: id.seed,
            latency: id.latency,
            key: key.to_owned(),
            ..self
        }
    }

    /// The row without the columns that depend on the wall clock or the machine: the same bits on every machine.
    #[must_use]
    pub fn without_clock(self) -> Self {
        Self {
            ran_on: None,
            machine: None,
            threads: None,
            tick_p50_ms: None,
            tick_p95_ms: None,
            tick_p99_ms: None,
            tick_max_ms: None,
            ..self
        }
    }

    /// Whether the run reached its goal.
    #[must_use]
    pub fn reached(&self) -> bool {
        self.outcome == RunOutcome::Reached
    }

    /// Fills in the figures of a run.
    pub(super) fn fill(&mut self, result: &MissionResult) {
        let (x_m, y_m) = result.final_error_m;
        self.fault = result.fault.as_ref().map(|it| fault_name(&it.to_string()));
        self.time_s = result.time_s;
        self.travelled_m = result.travelled_m;
        self.min_clearance_m = Some(result.min_clearance_m).filter(|gap_m| gap_m.is_finite());
        self.final_error_m = Some(libm::hypot(x_m, y_m));
        self.final_yaw_error_rad = result.final_yaw_error;
        self.plans = result.plans.len();
        self.ticks = result.trace.rows.len();
        self.trace_digest = Some(result.trace.digest());
    }

    /// Fills in the times of the ticks.
    pub(super) fn fill_times(&mut self, seconds: &[f64]) {
        let mut times = Latencies::default();
        for &seconds in seconds {
            // A clock that ran backwards gives no time.
            let _ = times.record(seconds);
        }
        let times = times.summary();
        let time = |figure: fn(&LatencySummary) -> f64| times.as_ref().map(figure);
        self.tick_p50_ms = time(|times| times.p50_ms);
        self.tick_p95_ms = time(|times| times.p95_ms);
        self.tick_p99_ms = time(|times| times.p99_ms);
        self.tick_max_ms = time(|times| times.max_ms);
    }
}

/// Nav2's name at the beginning of a fault's sentence; `FAULT` where it has none.
pub(super) fn fault_name(sentence: &str) -> String {
    let name = sentence.split(':').next().unwrap_or_default();
    let is_name = !name.is_empty() && name.chars().all(|c| c.is_ascii_uppercase() || c == '_');
    if is_name { name } else { "FAULT" }.to_owned()
}
