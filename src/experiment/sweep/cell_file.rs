//! The file of a cell: what went in, what came out, and a digest of both.

use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::cell::key;
use super::{CellLatency, FORMAT, Outcome, SweepError};
use crate::digest::BitDigest;

/// What a cell leaves behind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CellFile {
    /// The cell's key.
    pub key: String,
    /// What its result depends on.
    pub inputs: Value,
    /// Its result.
    pub outcome: Outcome,
    /// What the clock said, of a latency cell.
    pub latency: Option<CellLatency>,
}

impl CellFile {
    /// Two lines: the cell as JSON, and the SHA-256 of the first line.
    #[must_use]
    pub fn text(&self) -> String {
        // Numbers and words, which JSON has no trouble with.
        let line = serde_json::to_string(self).unwrap_or_default();
        let digest = digest(&line);
        format!("{line}\n{digest}\n")
    }

    /// Reads the file of the cell with this key.
    ///
    /// # Errors
    /// [`SweepError::BadCell`] when a byte of it is not as it was written, or it is of another cell;
    /// [`SweepError::OtherVersion`] when another version wrote it.
    pub fn parse(bytes: &[u8], file: &Path, expected: &str) -> Result<Self, SweepError> {
        let bad = |reason: &str| SweepError::BadCell {
            file: file.to_owned(),
            reason: reason.to_owned(),
        };
        let text = str::from_utf8(bytes).map_err(|_| bad("it is no text"))?;
        let lines = text
            .strip_suffix('\n')
            .and_then(|text| text.split_once('\n'));
        let (line, written) = lines.ok_or_else(|| bad("it does not have two lines"))?;
        if digest(line) != written {
            return Err(bad("its digest is not that of its line"));
        }
        let read: Self = serde_json::from_str(line).map_err(|_| bad("it is no cell"))?;
        if read.key != expected || key(&read.inputs) != expected {
            return Err(bad("it is of another cell than its name says"));
        }
        let found = &read.inputs;
        let version = found["version"].as_str().unwrap_or_default().to_owned();
        let format = found["format"].as_u64().unwrap_or_default() as u32;
        if (version.as_str(), format) != (env!("CARGO_PKG_VERSION"), FORMAT) {
            return Err(SweepError::OtherVersion {
                file: file.to_owned(),
                found: (version, format),
                expected: (env!("CARGO_PKG_VERSION").to_owned(), FORMAT),
            });
        }
        Ok(read)
    }
}

fn digest(line: &str) -> String {
    let mut digest = BitDigest::default();
    digest.text(line);
    digest.hex()
}
