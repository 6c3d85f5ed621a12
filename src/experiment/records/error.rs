//! What can be wrong with a record.

use std::path::PathBuf;

use thiserror::Error;

/// A file that holds no record that can be drawn.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum RecordError {
    /// The first line names the columns of no record that is known.
    #[error(
        "{}: line 1 has not the columns of a record that can be drawn: name a CSV file of --record, --record-quality or \
         --record-missions of `bench density`, of --record of `bench barn`, `bench dynabarn`, `bench soak` or `bench \
         ablation`, or groups of `sweep merge`", file.display()
    )]
    OtherColumns {
        /// The file.
        file: PathBuf,
    },
    /// A line that is no row.
    #[error("{}: line {line}: {reason}: mend that line, or measure again", file.display())]
    BadRow {
        /// The file.
        file: PathBuf,
        /// The line, from one.
        line: usize,
        /// What is wrong with it.
        reason: String,
    },
    /// Nothing below the names of the columns.
    #[error("{}: holds no row: name a record that has some", file.display())]
    NoRow {
        /// The file.
        file: PathBuf,
    },
    /// Missions that were driven for another purpose, or for several.
    #[error(
        "{}: its missions were driven with {setup:?}, which is no sampling such as 16x64, no soak and no variant of an \
         ablation alone: name a record of `bench density --record-missions`, `bench soak` or `bench ablation`", file.display()
    )]
    NoSampling {
        /// The file.
        file: PathBuf,
        /// Name of the settings.
        setup: String,
    },
}
