//! The error of experiments.

use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::bench::paper::PaperError;
use crate::input_file::read_text;
use crate::map::MapError;
use crate::runtime::TomlError;
use crate::settings::{KeyError, SettingError};
use crate::sim::SimError;

/// An experiment that cannot be planned, run, resumed, merged or read.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ExperimentError {
    /// A value that cannot be used.
    #[error("{key} is {value}: it must be {expected}")]
    BadValue {
        /// The path of the key in the plan, such as `worlds.0.path`, or the name of the rule.
        key: String,
        /// As given.
        value: String,
        /// What is accepted.
        expected: &'static str,
    },
    /// A value that a list has more than once.
    #[error("{key} has {value} more than once: name each value once")]
    Repeated {
        /// The path of the key in the plan.
        key: String,
        /// The value.
        value: String,
    },
    /// A number of the plan out of its range.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// Settings of the plan that cannot be used.
    #[error("{place}: {error}")]
    BadSettings {
        /// The key of the plan.
        place: String,
        /// What is wrong with them.
        error: TomlError,
    },
    /// A world, or a part of the plan, that cannot be used.
    #[error("{place}: {reason}")]
    Unusable {
        /// The key of the plan, or the name of the world.
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
    #[error("no cell of this plan has the key {key} of --cell: --list prints the keys")]
    NoCell {
        /// The key.
        key: String,
    },
    /// A file or folder of worlds, results or rows that cannot be used.
    #[error("{}: {reason}", file.display())]
    BadFile {
        /// The file or folder.
        file: PathBuf,
        /// What is wrong with it, where, and the cure.
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
    /// A run whose GPU failed: the CPU took decisions in its place.
    #[error(
        "{reason}: the CPU took {on_cpu} of {decisions} decisions in its place, so the run is no result; drive it again"
    )]
    GpuFailed {
        /// Decisions that the CPU took.
        on_cpu: u64,
        /// All decisions of the run.
        decisions: u64,
        /// The first failure.
        reason: String,
    },
    /// A map that cannot be read, or a world too large for one grid.
    #[error(transparent)]
    Map(#[from] MapError),
    /// A mission or setting out of range.
    #[error(transparent)]
    Simulation(#[from] SimError),
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

impl ExperimentError {
    /// The text of a file of worlds.
    pub(super) fn read(file: &Path) -> Result<String, Self> {
        read_text(file).map_err(|error| Self::file(file, error.to_string()))
    }

    pub(super) fn file(file: &Path, reason: impl Into<String>) -> Self {
        Self::BadFile { file: file.to_owned(), reason: reason.into() }
    }

    /// The same error, seen from the plan that has the checked table as its key.
    pub(super) fn in_table(self, table: &str) -> Self {
        match self {
            Self::Setting(error) => Self::Setting(error.in_table(table)),
            Self::BadValue { key, value, expected } => {
                Self::BadValue { key: format!("{table}.{key}"), value, expected }
            }
            Self::Repeated { key, value } => {
                Self::Repeated { key: format!("{table}.{key}"), value }
            }
            Self::Unusable { place, reason } => {
                Self::Unusable { place: format!("{table}.{place}"), reason }
            }
            other => other,
        }
    }
}

impl KeyError for ExperimentError {
    fn key_path(&self) -> Option<String> {
        match self {
            Self::Setting(error) => error.key_path(),
            Self::BadValue { key, .. } | Self::Repeated { key, .. } => Some(key.clone()),
            Self::BadSettings { place, error } => {
                Some(error.key_path().map_or_else(|| place.clone(), |key| format!("{place}.{key}")))
            }
            Self::Unusable { place, .. } => Some(place.clone()),
            _ => None,
        }
    }
}
