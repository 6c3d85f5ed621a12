//! Results of several folders as one table.

use std::collections::BTreeMap;
use std::path::PathBuf;

use super::{CellFile, ExperimentError, Manifest, RunRow};

/// One table, and the cells that it lacks.
#[derive(Clone, Debug, Default, PartialEq)]
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
        match by_key.get(&key) {
            Some((first, known)) => {
                let listed = manifest.cells.iter().find(|cell| cell.key == key);
                let id = listed.map(|cell| &cell.id);
                // The stored names are those of the plan that ran the cell, not of this one.
                let result = |row: &RunRow| {
                    let row = row.clone().without_clock();
                    id.map_or_else(|| row.clone(), |id| row.clone().named(id, &key))
                };
                if result(known) != result(&file.row) {
                    let files = [first.clone(), path];
                    return Err(ExperimentError::Differs { key, files });
                }
            }
            None => {
                by_key.insert(key, (path, file.row));
            }
        }
    }
    let row = |cell: &super::ListedCell| {
        let (_, row) = by_key.get(&cell.key)?;
        Some(row.clone().named(&cell.id, &cell.key))
    };
    let missing = manifest.keys().into_iter();
    Ok(Merged {
        rows: manifest.cells.iter().filter_map(row).collect(),
        missing: missing.filter(|key| !by_key.contains_key(*key)).map(str::to_owned).collect(),
    })
}
