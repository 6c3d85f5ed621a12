//! Errors of `DynaBARN` world files.

use std::path::PathBuf;

use thiserror::Error;

use crate::experiment::UnknownWorld;

/// Worlds that cannot be read.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum DynaBarnError {
    /// A file or folder that cannot be read.
    #[error("{}: cannot be read ({reason}): check the path and its permissions", file.display())]
    Unreadable {
        /// The file or folder.
        file: PathBuf,
        /// The system's message.
        reason: String,
    },
    /// A folder without a world.
    #[error("{}: holds no world_NN.json: check that it is the right folder", folder.display())]
    NoWorld {
        /// The folder.
        folder: PathBuf,
    },
    /// A requested world that does not exist.
    #[error(transparent)]
    UnknownWorld(#[from] UnknownWorld),
    /// A file that is no world.
    #[error("{}: no world of moving cylinders: {reason}", file.display())]
    NotAWorld {
        /// The file.
        file: PathBuf,
        /// What is wrong, and where.
        reason: String,
    },
    /// A number out of range.
    #[error("{}: {place} is {value}: it must be {expected}", file.display())]
    BadNumber {
        /// The file.
        file: PathBuf,
        /// Which number.
        place: String,
        /// As given.
        value: f64,
        /// What is accepted.
        expected: &'static str,
    },
}
