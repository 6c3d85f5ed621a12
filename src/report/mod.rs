//! Writes reports: self-contained HTML pages, and SVG or PNG pictures, from plans, drives and measurements.
//!
//! - [`html`]: a page on missions, with maps, charts and a player.
//! - [`bench_files`], [`bench_svg`]: a page and pictures of benchmarks and experiments.
//! - [`comparison_files`]: a ranking of planners.
//! - [`paper_files`]: the page of the paper's experiments.
//! - [`plan_svg`], [`drive_svg`], [`decision_svg`]: one map as a picture.
//! - `gif_animation`: a drive as an animation, with the feature `png`.
//!
//! All functions are pure: data in, text or pixels out, and the same data give the same bytes. A page needs no network. Its
//! pictures are SVG, and each has a table of its data.

#[cfg(feature = "png")]
mod animation;
mod bench_page;
mod chart;
mod comparison_page;
mod decision_picture;
mod figure;
mod map;
mod map_pictures;
mod mission_charts;
mod mission_page;
mod mission_set_charts;
mod number;
mod page;
mod paper_charts;
mod paper_maps;
mod paper_page;
mod paper_tables;
mod player;
#[cfg(feature = "png")]
mod png;
mod run_charts;
mod sample_charts;
mod svg;
mod sweep_charts;

#[cfg(feature = "png")]
pub use animation::{AnimationError, gif_animation};
pub use bench_page::{BenchReport, bench_files, bench_svg};
pub use comparison_page::{ComparisonReport, SearchResult, comparison_files};
pub use decision_picture::{DecisionView, decision_svg};
pub use map::PathStages;
pub use map_pictures::{DriveView, PlanMetrics, PlanOutcome, PlanView, drive_svg, plan_svg};
pub use mission_page::{EngineComparison, MissionView, Report, html};
pub use page::ReportFile;
#[cfg(feature = "playground")]
pub(crate) use page::STYLE;
pub use paper_page::{PaperReport, paper_files};
pub use paper_tables::paper_text;
#[cfg(feature = "playground")]
pub(crate) use player::COPY_SCRIPT;
pub use player::PlaybackRecorder;
#[cfg(feature = "server")]
pub(crate) use player::{KnownPlayback, LivePage};
#[cfg(feature = "png")]
pub use png::{PngError, png};
