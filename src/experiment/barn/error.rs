//! Errors of BARN world files.

use std::path::PathBuf;

use thiserror::Error;

use crate::experiment::UnknownWorld;

/// Worlds that cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum BarnError {
    /// A file that cannot be read.
    #[error("{}: cannot be read ({reason}): name a folder that holds worlds.csv and worlds/world_NNN.csv", file.display())]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// The system's message.
        reason: String,
    },
    /// A table without a required column.
    #[error("{}: line 1: no column `{column}`: check that it is the right file", file.display())]
    NoColumn {
        /// The file.
        file: PathBuf,
        /// The column.
        column: &'static str,
    },
    /// A table without a row.
    #[error("{}: holds no {what}: check that it is the right file", file.display())]
    NoRow {
        /// The file.
        file: PathBuf,
        /// What its rows describe.
        what: &'static str,
    },
    /// A row with too few or too many fields.
    #[error("{}: line {line}: {found} fields; expected {expected}, as many as line 1 has", file.display())]
    BadRow {
        /// The file.
        file: PathBuf,
        /// The line, from one.
        line: usize,
        /// Number of its fields.
        found: usize,
        /// Number of columns.
        expected: usize,
    },
    /// A field whose value does not fit its column.
    #[error("{}: line {line}: {column} is {found:?}: it must be {expected}", file.display())]
    BadField {
        /// The file.
        file: PathBuf,
        /// The line, from one.
        line: usize,
        /// The column.
        column: &'static str,
        /// As given.
        found: String,
        /// What is accepted.
        expected: &'static str,
    },
    /// A requested world that does not exist.
    #[error(transparent)]
    UnknownWorld(#[from] UnknownWorld),
}
