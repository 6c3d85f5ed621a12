//! Runs every combination of worlds, settings, engines and seeds in the simulator, and makes one row for each run.
//!
//! A combination is a [`Cell`]. Its result is a pure function of its inputs, and its key is a digest of them: any machine may
//! run it, and no run is repeated. Only times depend on the machine; they are in separate columns.
//!
//! [`Grid`] makes the cells of a [`Plan`] or of a built-in experiment, [`run_cell`] drives one, [`merge`] makes a table of the
//! results, and [`groups`] its summary. This module writes no files: [`CellFile`] and [`Manifest`] define their content.

mod ablation;
pub mod barn;
mod cell;
mod csv_file;
pub mod dynabarn;
mod error;
mod fault_matrix;
mod grid;
mod group;
mod localization;
mod metrics;
pub mod missions;
mod mrpb;
mod outcome;
pub mod paper_drives;
#[cfg(feature = "parquet")]
mod parquet;
mod plan;
mod plan_worlds;
mod programs;
mod ranking;
mod records;
mod results;
mod row;
mod row_figures;
mod run;
mod soak;
mod tuning;
mod workers;
mod world;

pub use ablation::{ABLATION_VARIANTS, AblationVariant, ablation_groups};
pub use cell::{Cell, FORMAT, Shard};
pub use error::ExperimentError;
pub use fault_matrix::{FaultRow, simulated_fault_names, simulated_faults};
pub use grid::{Grid, Setup, sampling_setups, wall_clock_setting};
pub use group::{Group, faults, groups};
#[cfg(feature = "report")]
pub(crate) use group::{by_settings, by_world, grouped};
pub use localization::{LocalizationCase, LocalizationSite, localization_config};
pub use missions::TrafficKind;
pub use outcome::{ContactCause, RunOutcome};
#[cfg(feature = "parquet")]
pub use parquet::parquet_bytes;
pub use plan::{Changes, Plan, PlanRoute, PlanWorlds, SamplingGrid, WorldKind};
pub use plan_worlds::built_in_maps;
pub use programs::check_programs;
pub use ranking::{RankStatus, RankedPlanner, fault_text, planner_names, rankings};
pub use records::{Record, read_record};
pub use results::{CellFile, Manifest, Merged, merge};
pub use row::RunRow;
pub use run::{Run, open_engine, run_cell};
pub use soak::{
    Comparison, FinalError, IdentifiedMotion, Share, SoakSummary, Spread, compare_digests,
    spread_evenly,
};
pub use tuning::{Point, SearchRange, TuningPlan};
pub use workers::{run_in_order, run_in_order_checked, run_jobs};
pub use world::{World, WorldSettings, WorldSimulation};
