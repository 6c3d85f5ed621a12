//! Runs every combination of worlds, settings, engines and seeds in the simulator, and makes one row for each run.
//!
//! A combination is a [`Cell`]. Its result is a pure function of its inputs, and its key is a digest of them: any machine may
//! run it, and no run is repeated. Only times depend on the machine; they are in separate columns.
//!
//! [`Grid`] makes the cells of a [`Plan`] or of a built-in experiment, [`run_cell`] drives one, [`merge`] makes a table of the
//! results, and [`groups`] its summary. This module writes no files: [`CellFile`] and [`Manifest`] define their content.

mod ablation;
pub mod barn;
mod canonical;
mod cell;
mod cell_file;
mod contact;
pub mod dynabarn;
mod error;
mod grid;
mod group;
mod localization;
mod manifest;
mod merge;
pub mod missions;
mod outcome;
pub mod paper_drives;
#[cfg(feature = "parquet")]
mod parquet;
mod plan;
mod plan_check;
mod plan_worlds;
mod records;
mod replay_check;
mod row;
mod run;
mod sampling_grid;
mod shard;
mod soak;
mod workers;
mod world;
mod world_numbers;

pub use ablation::{ABLATION_VARIANTS, AblationVariant, ablation_groups};
pub use cell::{Cell, CellId, FORMAT};
pub use cell_file::CellFile;
pub use contact::{Contact, TouchedBody, contact};
pub use error::{ExperimentError, RunError};
pub use grid::{Grid, Setup, sampling_setups};
pub use group::{Group, faults, groups, groups_by};
pub use localization::{LocalizationCase, LocalizationPlan, LocalizationRow};
pub use manifest::{ListedCell, Manifest};
pub use merge::{Merged, merge};
pub use missions::TrafficKind;
#[cfg(feature = "parquet")]
pub use parquet::parquet_bytes;
pub use plan::{Plan, PlanRoute, PlanWorlds, WorldKind};
pub use plan_worlds::built_in_maps;
pub use records::{Record, RecordError, read_record};
pub use replay_check::{Comparison, compare_digests, spread_evenly};
pub use row::{ContactCause, RunOutcome, RunRow};
pub use run::{Run, open_engine, run_cell};
pub use sampling_grid::SamplingGrid;
pub use shard::Shard;
pub use soak::{FinalError, SoakSummary};
pub use workers::{run_in_order, run_jobs};
pub use world::{World, WorldSimulation};
pub use world_numbers::UnknownWorld;
