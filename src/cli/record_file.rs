//! Tables of rows in files.

use inbye::bench::{Columns, csv_text};

use super::output_file::Output;

/// Writes rows, as JSON or CSV by the file's ending.
pub fn write<R: Columns>(file: Output, rows: &[R]) -> anyhow::Result<()> {
    let text = if file.extension() == "json" {
        serde_json::to_string_pretty(rows)? + "\n"
    } else {
        csv_text(rows)
    };
    file.write(text)
}
