//! What can be wrong with the files of worlds that move.

use std::path::PathBuf;

use thiserror::Error;

use crate::experiment::worlds::NotAmong;

/// Worlds that cannot be read.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum DynaBarnError {
    /// A file or folder that the system does not give.
    #[error("{}: cannot be read ({reason}): check the path and its permissions", file.display())]
    Unreadable {
        /// The file or folder.
        file: PathBuf,
        /// In the system's words.
        reason: String,
    },
    /// A folder without a world.
    #[error("{}: holds no world_NN.json: check that it is the right folder", folder.display())]
    NoWorld {
        /// The folder.
        folder: PathBuf,
    },
    /// A world asked for that is not there.
    #[error(transparent)]
    NotAmong(#[from] NotAmong),
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
        /// What would be accepted.
        expected: &'static str,
    },
}
