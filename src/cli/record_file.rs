//! Writes rows of benchmarks into files.

use inbye::bench::movingai::AlgorithmRow;
use inbye::bench::{Columns, csv_text};
use serde::Serialize;

use super::output_file::Output;

/// Results of an algorithm on the scenarios of a map.
#[derive(Serialize)]
pub struct MapAlgorithm {
    /// Name of the map.
    pub map: String,
    /// Results of the algorithm.
    #[serde(flatten)]
    pub row: AlgorithmRow,
}

impl Columns for MapAlgorithm {
    const COLUMNS: &[&str] = &[
        "map",
        "name",
        "exact",
        "solved",
        "total",
        "suboptimal",
        "illegal",
        "median_us",
        "p95_us",
        "max_us",
        "expanded",
        "mean_length_ratio",
        "worst_length_ratio",
        "first_fault",
    ];
}

/// Writes rows as JSON or CSV by the file's extension.
pub fn write<R: Columns>(file: Output, rows: &[R]) -> anyhow::Result<()> {
    let text = if file.extension() == "json" {
        serde_json::to_string_pretty(rows)? + "\n"
    } else {
        csv_text(rows)
    };
    file.write(text)
}
