//! Rows as lines of a CSV file.

use csv::{ErrorKind, StringRecord, Writer};
use serde::Serialize;
use serde_json::Value;

/// A flat record of numbers, texts and truths that has a line in a CSV file.
pub trait Columns: Serialize {
    /// The names of the fields that the file has, in the order of its columns.
    const COLUMNS: &[&str];
}

/// A CSV file of rows: a line with the names of the columns, and a line for each row.
#[must_use]
pub fn csv_text<R: Columns>(rows: &[R]) -> String {
    let lines = rows.iter().map(|row| csv_line(fields(row)));
    csv_line(R::COLUMNS) + &lines.collect::<String>()
}

/// The fields of a row as text, in the order of its columns; nothing for null.
pub(crate) fn fields<R: Columns>(row: &R) -> impl Iterator<Item = String> {
    // A row is a flat record, which JSON has no trouble with; were it not, its line would be empty fields.
    let record = serde_json::to_value(row).unwrap_or_default();
    R::COLUMNS.iter().map(move |&name| field(&record[name]))
}

fn field(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        // A line is a line: what is torn off ends at a break.
        Value::String(text) => text.replace(['\n', '\r'], " "),
        other => other.to_string(),
    }
}

/// The line of these fields, with its end.
pub(crate) fn csv_line(fields: impl IntoIterator<Item: AsRef<[u8]>>) -> String {
    let mut writer = Writer::from_writer(Vec::new());
    writer.write_record(fields).expect("memory takes all");
    let bytes = writer.into_inner().expect("memory takes all");
    String::from_utf8(bytes).expect("texts joined by commas are text")
}

/// What is wrong with a row, by the name of the column.
pub(crate) fn said(error: &csv::Error, header: &StringRecord) -> String {
    match error.kind() {
        ErrorKind::Deserialize { err, .. } => {
            let column = err.field().and_then(|field| header.get(field as usize));
            format!("{}: {}", column.unwrap_or("the row"), err.kind())
        }
        _ => error.to_string(),
    }
}
