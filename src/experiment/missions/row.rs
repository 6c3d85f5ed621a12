//! What a mission leaves behind.

use core::fmt::{self, Display};

use serde::{Deserialize, Serialize};

use super::People;
use crate::bench::Columns;
use crate::experiment::campaign::Row;

/// How a mission ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Ending {
    /// The robot stands at its goal.
    Reached,
    /// The navigator gave up, with a reason.
    Failed,
    /// The robot and something touched.
    Contact,
    /// The time was up.
    Timeout,
}

/// Whose motion closed the gap of a contact, where there was one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Touch {
    /// The robot's.
    #[serde(rename = "robot")]
    Robot,
    /// That of what it touched, alone.
    #[serde(rename = "other")]
    Other,
    /// There was no contact.
    #[serde(rename = "-")]
    None,
}

/// Which mission, driven how.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct MissionKey {
    /// The setup's name.
    pub setup: String,
    /// The map's name.
    pub map: String,
    /// The mission's seed.
    pub seed: u64,
}

impl Display for MissionKey {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}, {}, seed {}", self.setup, self.map, self.seed)
    }
}

/// One mission.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MissionRow {
    /// Name of the settings that it was driven with.
    pub setup: String,
    /// Name of the map.
    pub map: String,
    /// Seed of the mission.
    pub seed: u64,
    /// Who walked there.
    pub people: People,
    /// How many.
    pub moving: usize,
    /// Things on the way that the map does not show.
    pub unmapped: usize,
    /// How it ended.
    pub result: Ending,
    /// Simulated time, seconds.
    pub time_s: f64,
    /// Length of the first global path, metres.
    pub path_m: f64,
    /// Way driven, metres.
    pub travelled_m: f64,
    /// Smallest true gap on the way, metres; none where no tick was driven.
    pub min_clearance_m: Option<f64>,
    /// Whose motion closed the gap of a contact.
    pub contact: Touch,
    /// Why the navigator gave up, in Nav2's word; none where it did not.
    pub fault: Option<String>,
    /// Why the goal was not reached, a sentence; none where it was.
    pub reason: Option<String>,
    /// True distance from the goal at the end, metres.
    pub final_error_m: f64,
    /// True yaw less the goal's at the end, radians, -pi to pi.
    pub final_yaw_error_rad: Option<f64>,
    /// Global plans.
    pub plans: usize,
    /// Ticks.
    pub ticks: usize,
    /// Digest of the trace; none where no tick was driven.
    pub trace_digest: Option<String>,
    /// What the decisions were computed on.
    pub engine: String,
    /// Wall-clock time of a whole tick of the navigator, from the scan to the command, the median, milliseconds.
    pub tick_p50_ms: Option<f64>,
    /// The same, the 99th percentile.
    pub tick_p99_ms: Option<f64>,
}

impl Columns for MissionRow {
    const COLUMNS: &[&str] = &[
        "setup",
        "map",
        "seed",
        "people",
        "moving",
        "unmapped",
        "result",
        "time_s",
        "path_m",
        "travelled_m",
        "min_clearance_m",
        "contact",
        "fault",
        "reason",
        "final_error_m",
        "final_yaw_error_rad",
        "plans",
        "ticks",
        "trace_digest",
        "engine",
        "tick_p50_ms",
        "tick_p99_ms",
    ];
}

impl Row for MissionRow {
    type Key = MissionKey;

    fn key(&self) -> MissionKey {
        MissionKey {
            setup: self.setup.clone(),
            map: self.map.clone(),
            seed: self.seed,
        }
    }
}
