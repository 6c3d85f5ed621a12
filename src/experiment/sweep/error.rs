//! What can be wrong with a sweep.

use std::path::PathBuf;

use thiserror::Error;

use crate::experiment::barn::BarnError;
use crate::experiment::dynabarn::DynaBarnError;
use crate::map::MapError;

/// A sweep that cannot be made, gone on with, or merged.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SweepError {
    /// A key of a plan whose value cannot be used.
    #[error("{key} is {value}: it must be {expected}")]
    BadKey {
        /// The key.
        key: &'static str,
        /// As given.
        value: String,
        /// What would be accepted.
        expected: &'static str,
    },
    /// Settings that make runs depend on the wall clock.
    #[error(
        "configs.{config}: navigator.{key} makes a run depend on the wall clock, and a cell must not: leave it out"
    )]
    NotPure {
        /// Name of the changes.
        config: String,
        /// The key.
        key: &'static str,
    },
    /// Changes that cannot be made to the settings.
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
    /// A part of the cells that there is not.
    #[error(
        "`{text}` is no shard: write I/N, such as 1/4, with I from 1 to N, and N at most 1000000"
    )]
    BadShard {
        /// As given.
        text: String,
    },
    /// A key that no cell has.
    #[error("no cell of this plan has the key {key}: `--list` tells those that it has")]
    NoCell {
        /// The key.
        key: String,
    },
    /// A file of a cell that is not what was written.
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
    /// A file that does not say which cells there are.
    #[error("{}: {reason}: name a folder that `inbye sweep --out` made", file.display())]
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
        /// How many cells these have.
        cells: [usize; 2],
    },
    /// Folders written by several versions of this program.
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
    /// A table that cannot be written as Parquet.
    #[error("Parquet: {reason}")]
    Parquet {
        /// Why.
        reason: String,
    },
}
