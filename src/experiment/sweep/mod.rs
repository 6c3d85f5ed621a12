//! Sweeps: every combination of worlds, settings, weights, samplings, engines and seeds that a plan names, a cell for each.
//!
//! What a cell gives is a pure function of its inputs, and its key is a digest of them, so that any machine may run it, and
//! nobody need run it twice. Only the times of a latency cell are the clock's, and they stand in a table of their own.
//!
//! No file is written here: a [`CellFile`] says what its file shall hold, and a [`Manifest`] which cells there are.

mod canonical;
mod cell;
mod cell_file;
mod error;
mod grid;
mod ground;
mod label;
mod manifest;
mod merge;
mod outcome;
#[cfg(feature = "parquet")]
mod parquet;
mod plan;
mod plan_check;
mod run;
mod sampling_grid;
mod shard;
mod summary;
mod table;
mod worlds;

pub use cell::{Cell, FORMAT};
pub use cell_file::CellFile;
pub use error::SweepError;
pub use grid::Grid;
pub use label::Label;
pub use manifest::{ListedCell, Manifest};
pub use merge::{Merged, merge};
pub use outcome::{CellLatency, CellResult, Outcome};
#[cfg(feature = "parquet")]
pub use parquet::parquet_bytes;
pub use plan::{Route, SweepPlan, SweepWorlds, WorldKind};
pub use run::{open_engine, run_cell};
pub use sampling_grid::SamplingGrid;
pub use shard::Shard;
pub use summary::{SweepGroup, groups};
pub use table::{LatencyRow, SweepRow};
