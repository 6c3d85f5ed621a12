//! Show: one page that a person can open, made from what was planned, driven and measured.
//!
//! Pure: data in, text or pixels out. The page holds everything it needs, so it opens from a file with no network; its
//! pictures are drawings in the page, and under each stands a table of the same numbers. The same data give the
//! same bytes.

mod ablation_chart;
mod ablation_page;
mod axis;
mod bench_page;
mod closed_loop_chart;
mod curves;
mod density_chart;
mod density_picture;
mod drive_picture;
mod encounters;
mod figure;
mod gap_chart;
mod latency;
mod latency_chart;
mod map_figure;
mod map_furniture;
mod map_layers;
mod map_motion;
mod map_picture;
mod mission;
mod motion_chart;
mod number;
mod own_picture;
mod page;
mod panel;
mod paper_bars;
mod paper_charts;
mod paper_drives;
mod paper_drives_chart;
mod paper_drives_maps;
mod paper_maps;
mod paper_page;
mod paper_tables;
mod plain_style;
mod plan_picture;
mod player;
#[cfg(feature = "png")]
mod png;
mod quality_chart;
mod raster;
mod report_files;
mod row_chart;
mod samples_axis;
mod sampling_shape;
mod sheet;
mod simplify;
mod snapshot;
mod soak_chart;
mod soak_groups;
mod sweep_chart;
mod sweep_latency_chart;
mod viewport;
mod world_runs;
mod worlds_chart;

use crate::bench::{DensityRow, QualityRow, SkippedCell};
use crate::geometry::{Point, Pose};
use crate::map::OccupancyGrid;
use crate::robot::Footprint;
use crate::runtime::Trace;

pub use ablation_page::{AblationReport, ablation_files};
pub use bench_page::{BenchReport, bench_files, bench_svg};
pub use density_picture::density_svg;
pub use drive_picture::{DriveView, drive_svg};
pub use page::{STYLE, html};
pub use paper_page::{PaperReport, paper_files};
pub use plan_picture::{PlanFigures, PlanOutcome, PlanView, plan_svg};
pub use player::Reel;
#[cfg(feature = "png")]
pub use png::{PngError, png};
pub use report_files::ReportFile;

/// All that one page shows. Text may hold any characters; it is escaped.
#[derive(Clone, Debug, Default)]
pub struct Report<'a> {
    /// The page's title.
    pub title: &'a str,
    /// What a reader should know first. An empty line starts a new paragraph.
    pub intro: &'a str,
    /// Where the numbers were measured: processor, adapter, system. Empty: not said.
    pub machine: &'a str,
    /// The missions, in the order in which they are shown.
    pub missions: Vec<MissionView<'a>>,
    /// What each engine made of the same problems. Empty: no such section.
    pub comparisons: &'a [EngineComparison],
    /// The density benchmark. Empty: no such section, unless there is a command for it.
    pub density: &'a [DensityRow],
    /// What it left out. Empty: nothing.
    pub skipped: &'a [SkippedCell],
    /// The commands of few samples beside those of many. Empty: no such chart.
    pub quality: &'a [QualityRow],
    /// How to run the density benchmark again. Empty: not said.
    pub density_command: &'a str,
}

/// One mission as the page shows it. Numbers that are not finite are left out of the drawings, and stand as a
/// dash in the text.
#[derive(Clone, Debug)]
pub struct MissionView<'a> {
    /// Heading of the section.
    pub title: &'a str,
    /// How to run the mission again.
    pub command: &'a str,
    /// The ground.
    pub map: &'a OccupancyGrid,
    /// Where the robot started.
    pub start: Pose,
    /// Where it was to go.
    pub goal: Point,
    /// The first global path as the search returned it.
    pub searched: &'a [Point],
    /// The same without redundant nodes.
    pub pruned: &'a [Point],
    /// The same, smoothed.
    pub smoothed: &'a [Point],
    /// What happened. Its first path is `smoothed`; the others were planned on the way.
    pub trace: &'a Trace,
    /// The robot's shape.
    pub footprint: &'a Footprint,
    /// How long each decision took, milliseconds, one for each row of the trace.
    pub latency_ms: &'a [f64],
    /// The engine that decided.
    pub engine: &'a str,
    /// What came of it.
    pub outcome: Outcome,
    /// Time from one decision to the next, seconds; the deadline of a decision.
    pub control_period_s: f64,
    /// The run tick by tick, to be played back. None: the page has no player for it, and needs no script.
    pub reel: Option<&'a Reel>,
    /// Further rows for the table of facts: name and value.
    pub facts: &'a [(String, String)],
}

/// What came of a mission.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// Whether the robot reached the goal.
    pub reached: bool,
    /// Whether it touched anything.
    pub collided: bool,
    /// Duration, simulated seconds.
    pub time_s: f64,
    /// Length of the driven track, metres.
    pub travelled_m: f64,
    /// Smallest gap to anything solid, metres; infinite when nothing was in reach.
    pub min_clearance_m: f64,
    /// Where the robot ended, less where it should have: metres and radians in the map frame.
    pub final_error: Pose,
}

/// One engine's answer to problems that all engines were given.
#[derive(Clone, Debug, PartialEq)]
pub struct EngineComparison {
    /// The engine's name, with its adapter's.
    pub name: String,
    /// Digest of its answers.
    pub digest: String,
    /// Whether they are those of the reference, bit for bit.
    pub agrees: bool,
}
