//! The list of all cells of a plan.

use std::collections::BTreeSet;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::{Cell, CellId, ExperimentError, FORMAT, Grid};

/// All cells of a plan by their names and keys, in the plan's order. It turns results into a table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// The crate's version.
    pub version: String,
    /// Number of the format of results.
    pub format: u32,
    /// The plan's title.
    pub title: String,
    /// The cells.
    pub cells: Vec<ListedCell>,
}

/// A cell by its names and key.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ListedCell {
    /// Its key.
    pub key: String,
    /// Its names.
    #[serde(flatten)]
    pub id: CellId,
}

impl Manifest {
    /// The manifest of a grid.
    #[must_use]
    pub fn of(grid: &Grid) -> Self {
        let listed = |cell: &Cell| ListedCell { key: cell.key.clone(), id: cell.id.clone() };
        Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            format: FORMAT,
            title: grid.title.clone(),
            cells: grid.cells.iter().map(listed).collect(),
        }
    }

    /// The text of its JSON file.
    #[must_use]
    pub fn text(&self) -> String {
        // Numbers and texts always serialise.
        serde_json::to_string(self).unwrap_or_default() + "\n"
    }

    /// Reads such a file.
    ///
    /// # Errors
    /// Fails when it is no manifest, or another version wrote it.
    pub fn parse(bytes: &[u8], file: &Path) -> Result<Self, ExperimentError> {
        let read: Self = serde_json::from_slice(bytes).map_err(|error| {
            ExperimentError::BadManifest { file: file.to_owned(), reason: error.to_string() }
        })?;
        let expected = (env!("CARGO_PKG_VERSION").to_owned(), FORMAT);
        if (&read.version, read.format) == (&expected.0, expected.1) {
            return Ok(read);
        }
        Err(ExperimentError::OtherVersion {
            file: file.to_owned(),
            found: (read.version, read.format),
            expected,
        })
    }

    /// The keys, each once, in order.
    #[must_use]
    pub fn keys(&self) -> Vec<&str> {
        let mut seen = BTreeSet::new();
        let keys = self.cells.iter().map(|cell| cell.key.as_str());
        keys.filter(|key| seen.insert(*key)).collect()
    }
}
