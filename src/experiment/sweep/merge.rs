//! Results of several folders as one table.

use std::collections::BTreeMap;
use std::path::PathBuf;

use super::{CellFile, LatencyRow, Manifest, SweepError, SweepRow};

/// One table, and what is missing in it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Merged {
    /// A row for each cell that has a result, in the plan's order: the same bits whoever ran them.
    pub rows: Vec<SweepRow>,
    /// What the clocks said of latency cells, likewise; they differ from run to run.
    pub latencies: Vec<LatencyRow>,
    /// Keys of the cells without a result.
    pub missing: Vec<String>,
}

/// Merges the results of folders of one plan. A cell that several of them have must be the same in all; its times are those
/// of the first.
///
/// # Errors
/// When a cell's results differ.
pub fn merge(manifest: &Manifest, files: Vec<(PathBuf, CellFile)>) -> Result<Merged, SweepError> {
    let mut by_key: BTreeMap<String, (PathBuf, CellFile)> = BTreeMap::new();
    for (path, file) in files {
        match by_key.get(&file.key) {
            Some((first, known)) if known.outcome != file.outcome => {
                return Err(SweepError::Differs {
                    key: file.key,
                    files: [first.clone(), path],
                });
            }
            Some(_) => {}
            None => {
                by_key.insert(file.key.clone(), (path, file));
            }
        }
    }
    let mut merged = Merged::default();
    for listed in &manifest.cells {
        let Some((_, file)) = by_key.get(&listed.key) else {
            continue;
        };
        merged.rows.push(SweepRow::new(listed, &file.outcome));
        let latency = file.latency.as_ref();
        merged
            .latencies
            .extend(latency.map(|latency| LatencyRow::new(listed, latency)));
    }
    let missing = manifest.keys().into_iter();
    merged.missing = missing
        .filter(|key| !by_key.contains_key(*key))
        .map(str::to_owned)
        .collect();
    Ok(merged)
}
