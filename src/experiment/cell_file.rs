//! The file of a cell: its inputs, its row, and a digest of both.

use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::cell::key;
use super::{ExperimentError, FORMAT, RunRow};
use crate::digest::BitDigest;

/// The result of a cell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CellFile {
    /// What its result depends on.
    pub inputs: Value,
    /// Its result, with its key.
    pub row: RunRow,
}

impl CellFile {
    /// The file's text: a line with the cell as JSON, and a line with the SHA-256 of the first.
    #[must_use]
    pub fn text(&self) -> String {
        // Numbers and texts always serialise.
        let line = serde_json::to_string(self).unwrap_or_default();
        let digest = digest(&line);
        format!("{line}\n{digest}\n")
    }

    /// Reads the file of the cell with this key.
    ///
    /// # Errors
    /// [`ExperimentError::BadCell`] when a byte differs from what was written, or the file is of another cell;
    /// [`ExperimentError::OtherVersion`] when another version wrote it.
    pub fn parse(bytes: &[u8], file: &Path, expected: &str) -> Result<Self, ExperimentError> {
        let bad = |reason: &str| ExperimentError::BadCell {
            file: file.to_owned(),
            reason: reason.to_owned(),
        };
        let text = str::from_utf8(bytes).map_err(|_| bad("it is no text"))?;
        let lines = text.strip_suffix('\n').and_then(|text| text.split_once('\n'));
        let (line, written) = lines.ok_or_else(|| bad("it does not have two lines"))?;
        if digest(line) != written {
            return Err(bad("its digest is not that of its line"));
        }
        let value: Value = serde_json::from_str(line).map_err(|_| bad("it is no cell"))?;
        let found = &value["inputs"];
        if key(found) != expected {
            return Err(bad("it is of another cell than its name says"));
        }
        let version = found["version"].as_str().unwrap_or_default().to_owned();
        let format = found["format"].as_u64().unwrap_or_default() as u32;
        if (version.as_str(), format) != (env!("CARGO_PKG_VERSION"), FORMAT) {
            return Err(ExperimentError::OtherVersion {
                file: file.to_owned(),
                found: (version, format),
                expected: (env!("CARGO_PKG_VERSION").to_owned(), FORMAT),
            });
        }
        let read: Self = serde_json::from_value(value).map_err(|_| bad("it is no cell"))?;
        if read.row.key != expected {
            return Err(bad("it is of another cell than its name says"));
        }
        Ok(read)
    }
}

fn digest(line: &str) -> String {
    let mut digest = BitDigest::default();
    digest.text(line);
    digest.hex()
}
