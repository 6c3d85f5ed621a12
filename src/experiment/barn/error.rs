//! What can be wrong with the files of worlds.

use std::path::PathBuf;

use thiserror::Error;

use crate::experiment::worlds::NotAmong;

/// Worlds that cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum BarnError {
    /// A file that the system does not give.
    #[error("{}: cannot be read ({reason}): name a folder that holds worlds.csv and worlds/world_NNN.csv", file.display())]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// In the system's words.
        reason: String,
    },
    /// A table without a column that it must have.
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
        /// What its rows are.
        what: &'static str,
    },
    /// A row with too few or too many fields.
    #[error("{}: line {line}: {found} fields; expected {expected}, as many as line 1 has", file.display())]
    BadRow {
        /// The file.
        file: PathBuf,
        /// The line, from one.
        line: usize,
        /// How many it has.
        found: usize,
        /// How many it should have.
        expected: usize,
    },
    /// A field that is not what its column holds.
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
        /// What would be accepted.
        expected: &'static str,
    },
    /// A world asked for that is not there.
    #[error(transparent)]
    NotAmong(#[from] NotAmong),
}
