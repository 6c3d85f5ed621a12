//! Results in files: the file of each cell, the list of all cells, and the table of several folders.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize, Serializer};
use serde_json::Value;

use super::cell::{is_key, key};
use super::{Cell, ExperimentError, FORMAT, Grid, RunRow};
use crate::digest::BitDigest;

/// Version of the crate.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The file of a cell: its result, and what the result depends on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
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
    /// Fails when a byte differs from what was written, the file is of another cell, or another version wrote it.
    pub fn parse(bytes: &[u8], file: &Path, expected: &str) -> Result<Self, ExperimentError> {
        let bad = |reason: &str| {
            let cure =
                "the file is damaged or was changed; delete it, and the cell is driven again";
            ExperimentError::file(file, format!("{reason}: {cure}"))
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
        let format = found["format"].as_u64().unwrap_or_default() as u32;
        check_version(found["version"].as_str().unwrap_or_default(), format, file)?;
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

/// Checks that this version wrote a file.
fn check_version(version: &str, format: u32, file: &Path) -> Result<(), ExperimentError> {
    if (version, format) == (VERSION, FORMAT) {
        return Ok(());
    }
    let reason = format!(
        "written by inbye {version} (format {format}), and this is {VERSION} (format {FORMAT}): merge with the version that \
         ran the cells, or run them again"
    );
    Err(ExperimentError::file(file, reason))
}

/// All cells of a plan by their names and keys, in the plan's order. It turns results into a table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Manifest {
    /// The crate's version.
    pub version: String,
    /// Number of the format of results.
    pub format: u32,
    /// The plan's title.
    pub title: String,
    /// The cells, without results.
    #[serde(serialize_with = "names_only")]
    pub cells: Vec<RunRow>,
}

fn names_only<S: Serializer>(cells: &[RunRow], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(cells.iter().map(RunRow::names))
}

impl Manifest {
    /// The manifest of a grid.
    #[must_use]
    pub fn of(grid: &Grid) -> Self {
        let names = |cell: &Cell| cell.row.clone();
        Self {
            version: VERSION.to_owned(),
            format: FORMAT,
            title: grid.title.clone(),
            cells: grid.cells.iter().map(names).collect(),
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
    /// Fails when it is no manifest, a key is malformed, or another version wrote it.
    pub fn parse(bytes: &[u8], file: &Path) -> Result<Self, ExperimentError> {
        let bad = |reason: String| {
            let cure = "name a folder that `inbye sweep` made";
            ExperimentError::file(file, format!("{reason}: {cure}"))
        };
        let read: Self = serde_json::from_slice(bytes).map_err(|error| bad(error.to_string()))?;
        check_version(&read.version, read.format, file)?;
        // A key is also the name of a file.
        if let Some(place) = read.cells.iter().position(|cell| !is_key(&cell.key)) {
            let key = &read.cells[place].key;
            return Err(bad(format!(
                "cells[{place}].key is {key:?}: it must be a digest of a cell"
            )));
        }
        Ok(read)
    }

    /// A row for each cell that has a result, in the plan's order: cells with different names may share a key, and so a result.
    pub fn rows<'r>(&self, result: impl Fn(&str) -> Option<&'r RunRow>) -> Vec<RunRow> {
        let row = |cell: &RunRow| Some(result(&cell.key)?.clone().named(cell));
        self.cells.iter().filter_map(row).collect()
    }

    /// The keys, each once, in order.
    #[must_use]
    pub fn keys(&self) -> Vec<&str> {
        let mut seen = BTreeSet::new();
        let keys = self.cells.iter().map(|cell| cell.key.as_str());
        keys.filter(|key| seen.insert(*key)).collect()
    }
}

/// One table, and the cells that it lacks.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Merged {
    /// A row for each cell that has a result, in the plan's order. Without their clock columns
    /// ([`RunRow::without_clock`]) they are the same on every machine.
    pub rows: Vec<RunRow>,
    /// Keys of the cells without a result.
    pub missing: Vec<String>,
}

/// Merges the results of folders of one plan. Results of one cell must be the same in all folders; its times are those of
/// the first.
///
/// # Errors
/// [`ExperimentError::Differs`] when a cell's results differ.
pub fn merge(
    manifest: &Manifest,
    files: Vec<(PathBuf, CellFile)>,
) -> Result<Merged, ExperimentError> {
    let mut by_key: BTreeMap<String, (PathBuf, RunRow)> = BTreeMap::new();
    for (path, file) in files {
        let key = file.row.key.clone();
        let Some((first, known)) = by_key.get(&key) else {
            by_key.insert(key, (path, file.row));
            continue;
        };
        // The stored names are those of the plan that ran the cell: another plan may have other names for it.
        let result = |row: &RunRow| row.clone().without_clock().named(&RunRow::default());
        if result(known) != result(&file.row) {
            let files = [first.clone(), path];
            return Err(ExperimentError::Differs { key, files });
        }
    }
    let missing = manifest.keys().into_iter();
    Ok(Merged {
        rows: manifest.rows(|key| by_key.get(key).map(|(_, row)| row)),
        missing: missing.filter(|key| !by_key.contains_key(*key)).map(str::to_owned).collect(),
    })
}
