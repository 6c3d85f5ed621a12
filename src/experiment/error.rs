//! Errors of experiments and of single runs.

use std::path::PathBuf;

use thiserror::Error;

use super::barn::BarnError;
use super::dynabarn::DynaBarnError;
use super::missions::MissionsError;
use crate::bench::paper::PaperError;
use crate::map::MapError;
use crate::sim::SimError;

/// A run that cannot start.
#[derive(Debug, Error)]
pub enum RunError {
    /// A world too large for one grid.
    #[error(transparent)]
    Map(#[from] MapError),
    /// No random mission on the map.
    #[error(transparent)]
    Missions(#[from] MissionsError),
    /// A mission or setting out of range.
    #[error(transparent)]
    Simulation(#[from] SimError),
}

/// A plan that cannot be run, resumed or merged.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ExperimentError {
    /// A key of a plan whose value cannot be used.
    #[error("{key} is {value}: it must be {expected}")]
    BadKey {
        /// The key.
        key: &'static str,
        /// As given.
        value: String,
        /// What is accepted.
        expected: &'static str,
    },
    /// Settings that make runs depend on the wall clock.
    #[error(
        "{place}: navigator.{key} makes a run depend on the wall clock, and a cell must not: leave it out"
    )]
    NotPure {
        /// The key of the plan.
        place: String,
        /// The setting.
        key: &'static str,
    },
    /// Changes that do not fit the settings.
    #[error("{place}: {reason}")]
    BadChange {
        /// The key of the plan.
        place: String,
        /// What is wrong with it.
        reason: String,
    },
    /// Two worlds of the same name.
    #[error("worlds: two are called {name}: rename a map, or name each once")]
    SameName {
        /// The name.
        name: String,
    },
    /// A shard that does not exist.
    #[error(
        "`{text}` is no shard: write I/N, such as 1/4, with I from 1 to N, and N at most 1000000"
    )]
    BadShard {
        /// As given.
        text: String,
    },
    /// A key that no cell has.
    #[error("no cell of this plan has the key {key}: list the cells of the plan")]
    NoCell {
        /// The key.
        key: String,
    },
    /// A damaged file of a cell.
    #[error(
        "{}: {reason}: the file is damaged or was changed; delete it, and the cell is driven again",
        file.display()
    )]
    BadCell {
        /// The file.
        file: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// A file that is no manifest.
    #[error("{}: {reason}: name a folder that `inbye sweep` made", file.display())]
    BadManifest {
        /// The file.
        file: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// Folders of several plans.
    #[error(
        "{} and {} are of different plans (`{}`, {} cells; `{}`, {} cells): merge folders of one plan",
        folders[0].display(), folders[1].display(), titles[0], cells[0], titles[1], cells[1]
    )]
    OtherPlan {
        /// Two of the folders.
        folders: [PathBuf; 2],
        /// Titles of their plans.
        titles: [String; 2],
        /// Numbers of their cells.
        cells: [usize; 2],
    },
    /// Results written by another version of this program.
    #[error(
        "{}: written by inbye {} (format {}), and this is {} (format {}): merge with the version that ran the cells, or run \
         them again",
        file.display(), found.0, found.1, expected.0, expected.1
    )]
    OtherVersion {
        /// The file.
        file: PathBuf,
        /// Its version and format.
        found: (String, u32),
        /// Those of this program.
        expected: (String, u32),
    },
    /// A cell whose results differ between folders.
    #[error(
        "cell {key} has other results in {} than in {}: a cell must give the same everywhere; one of the machines errs",
        files[0].display(), files[1].display()
    )]
    Differs {
        /// The cell's key.
        key: String,
        /// Both files.
        files: [PathBuf; 2],
    },
    /// A map that cannot be read.
    #[error(transparent)]
    Map(#[from] MapError),
    /// BARN worlds that cannot be read.
    #[error(transparent)]
    Barn(#[from] BarnError),
    /// `DynaBARN` worlds that cannot be read.
    #[error(transparent)]
    DynaBarn(#[from] DynaBarnError),
    /// Scenes of the paper without a path.
    #[error(transparent)]
    Paper(#[from] PaperError),
    /// A table that cannot be written as Parquet.
    #[error("Parquet: {reason}")]
    Parquet {
        /// Why.
        reason: String,
    },
}
