//! What is wrong with a recording.

use std::io;

use crate::map::MapError;
use crate::navigator::Fault;
use crate::sim::SimError;

/// Why a recording cannot be written or used.
#[derive(Debug, thiserror::Error)]
pub enum RecordingError {
    /// The file could not be read or written.
    #[error("{0}")]
    Io(#[from] io::Error),
    /// The system gives no thread to write on.
    #[error("no thread to write the recording on: {0}")]
    NoThread(io::Error),
    /// Not an MCAP file.
    #[error("is no MCAP file: give a recording of `inbye drive --record FILE.mcap`")]
    NotMcap,
    /// Not written by this program.
    #[error(
        "has no {missing}, so it is no recording of `inbye drive --record FILE.mcap`, or it was cut before its first tick"
    )]
    NotOurs {
        /// What is not there.
        missing: &'static str,
    },
    /// Written by another version.
    #[error(
        "is of format {found}; this inbye reads format {FORMAT}: replay it with the inbye that wrote it, {writer}"
    )]
    OtherFormat {
        /// As the file has it.
        found: String,
        /// The version that wrote it.
        writer: String,
    },
    /// What it says of the drive cannot be read.
    #[error("{name} in it cannot be read: {reason}")]
    BadHead {
        /// The attachment.
        name: &'static str,
        /// What is wrong.
        reason: String,
    },
    /// Its bytes are not as they were written.
    #[error("is damaged after {ticks} ticks: {reason}; take another copy of the file")]
    Damaged {
        /// Ticks read before.
        ticks: u64,
        /// What is wrong.
        reason: String,
    },
    /// Its map has no sound size.
    #[error("the map in it: {0}")]
    Map(#[from] MapError),
    /// Its settings are out of range.
    #[error("the configuration in it: {0}")]
    Sim(#[from] SimError),
    /// The drive could not begin.
    #[error("the drive in it cannot begin here: {0}")]
    Fault(#[from] Fault),
}

/// The format of what is written; a change that older readers would misread raises it.
pub const FORMAT: u32 = 2;
