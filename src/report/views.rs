//! The data of a report on missions.

use super::playback_recorder::PlaybackRecorder;
use crate::bench::{DensityRow, QualityRow, SkippedCell};
use crate::geometry::{Point, Pose};
use crate::map::OccupancyGrid;
use crate::robot::Footprint;
use crate::runtime::Trace;

/// The content of a page on missions. All texts may hold any characters.
#[derive(Clone, Debug, Default)]
pub struct Report<'a> {
    /// The title.
    pub title: &'a str,
    /// The introduction. An empty line starts a new paragraph.
    pub intro: &'a str,
    /// Processor, adapter and system of the measurements; empty: unknown.
    pub machine: &'a str,
    /// The missions, in their order on the page.
    pub missions: Vec<MissionView<'a>>,
    /// The digests of all engines for the same problems; empty: no such section.
    pub comparisons: &'a [EngineComparison],
    /// The density benchmark; the section is left out if this and its command are empty.
    pub density: &'a [DensityRow],
    /// The cells that the density benchmark left out.
    pub skipped: &'a [SkippedCell],
    /// Regrets against the densest sampling; empty: no such chart.
    pub quality: &'a [QualityRow],
    /// The command that repeats the density benchmark; empty: unknown.
    pub density_command: &'a str,
}

/// One mission of a page. Numbers that are not finite are left out of the pictures; the texts show a dash.
#[derive(Clone, Debug)]
pub struct MissionView<'a> {
    /// Heading of the section.
    pub title: &'a str,
    /// The command that repeats the mission.
    pub command: &'a str,
    /// The map.
    pub map: &'a OccupancyGrid,
    /// The start pose.
    pub start: Pose,
    /// The goal.
    pub goal: Point,
    /// The first global path as the search returned it.
    pub searched: &'a [Point],
    /// The first global path without redundant nodes.
    pub pruned: &'a [Point],
    /// The first global path, smoothed.
    pub smoothed: &'a [Point],
    /// The run. Its first path is `smoothed`; the others were planned during the drive.
    pub trace: &'a Trace,
    /// The footprint of the robot.
    pub footprint: &'a Footprint,
    /// The time of each decision, ms, one for each row of the trace.
    pub latency_ms: &'a [f64],
    /// The name of the engine.
    pub engine: &'a str,
    /// The outcome.
    pub outcome: Outcome,
    /// The control period, s, which is the deadline of a decision.
    pub control_period_s: f64,
    /// The recorded ticks for the player; none: no player and no script.
    pub playback: Option<&'a PlaybackRecorder>,
    /// Further rows of the table of facts: name and value.
    pub facts: &'a [(String, String)],
}

/// The outcome of a mission.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// Whether the robot reached the goal.
    pub reached: bool,
    /// Whether the robot touched anything.
    pub collided: bool,
    /// Simulated duration, s.
    pub time_s: f64,
    /// Length of the driven track, m.
    pub travelled_m: f64,
    /// Smallest gap to an obstacle, m; infinite if none was in range.
    pub min_clearance_m: f64,
    /// Final pose minus goal pose, m and rad in the map frame.
    pub final_error: Pose,
}

/// The answers of one engine to problems that all engines solved.
#[derive(Clone, Debug, PartialEq)]
pub struct EngineComparison {
    /// The name of the engine, with its adapter.
    pub name: String,
    /// The digest of its answers.
    pub digest: String,
    /// Whether its answers equal those of the reference, bit for bit.
    pub agrees: bool,
}
