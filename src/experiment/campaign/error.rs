//! What can be wrong with the file of a campaign.

use std::path::PathBuf;

use thiserror::Error;

/// A file that this campaign cannot go on with.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum CampaignError {
    /// The first line names other columns.
    #[error(
        "{}: line 1 is no header of this campaign (expected `{expected}`): name a new file, or the right one", file.display()
    )]
    OtherColumns {
        /// The file.
        file: PathBuf,
        /// The header that it should have.
        expected: String,
    },
    /// A row that was run with other settings.
    #[error(
        "{}: line {line} was run with other settings ({}, and these are {expected}): name a new file, or run with \
         the settings of that one", file.display(), found.escape_debug()
    )]
    OtherSettings {
        /// The file.
        file: PathBuf,
        /// The line, from one.
        line: usize,
        /// Digest of its settings.
        found: String,
        /// Digest of this campaign's settings.
        expected: String,
    },
    /// A line that is no row.
    #[error("{}: line {line}: {reason}: delete that line, or name a new file", file.display())]
    BadRow {
        /// The file.
        file: PathBuf,
        /// The line, from one.
        line: usize,
        /// What is wrong with it.
        reason: String,
    },
}
