//! A CSV file with named columns: rows of a record, or a list of worlds.

use core::str::FromStr;
use std::path::Path;

use csv::{Position, ReaderBuilder, StringRecord, Trim};
use serde::de::DeserializeOwned;

use super::ExperimentError;
use crate::bench::columns::{csv_error_text, field_text};
use crate::bench::{Column, ColumnKind, Columns};

/// The lines of a file as text. All but blank ones have the number of fields of the first.
pub(super) struct CsvFile<'a> {
    file: &'a Path,
    header: StringRecord,
    records: Vec<StringRecord>,
}

/// A line below the names of the columns.
pub(super) struct CsvLine<'a> {
    file: &'a CsvFile<'a>,
    record: &'a StringRecord,
}

impl<'a> CsvFile<'a> {
    pub fn parse(text: &str, file: &'a Path) -> Result<Self, ExperimentError> {
        // Rows of another length are refused below, with their line.
        let mut reader = ReaderBuilder::new()
            .flexible(true)
            .trim(Trim::Headers)
            .from_reader(text.trim_start_matches('\u{feff}').as_bytes());
        let unread = |error: csv::Error| {
            let line = error.position().map_or(1, Position::line);
            ExperimentError::file(file, format!("line {line}: {error}: correct that line"))
        };
        let header = reader.headers().map_err(unread)?.clone();
        let records = reader.records().map(|record| record.map(|record| unquoted(&record)));
        let records: Vec<StringRecord> = records.collect::<Result<_, _>>().map_err(unread)?;
        let read = Self { file, header, records };
        let mut filled = read.records.iter().filter(|record| !is_blank(record));
        filled.try_for_each(|record| read.check_length(record))?;
        Ok(read)
    }

    fn check_length(&self, record: &StringRecord) -> Result<(), ExperimentError> {
        let (line, found, expected) = (line(record), record.len(), self.header.len());
        if found == expected {
            return Ok(());
        }
        let reason = format!(
            "line {line}: {found} fields; expected {expected}, as many as line 1 has: correct that line, or make the file again"
        );
        Err(ExperimentError::file(self.file, reason))
    }

    /// The first of these columns that the file lacks.
    pub fn lacks<'c>(&self, columns: &[&'c str]) -> Option<&'c str> {
        columns.iter().copied().find(|column| self.place(column).is_none())
    }

    fn place(&self, column: &str) -> Option<usize> {
        self.header.iter().position(|name| name == column)
    }

    /// The lines, without blank ones.
    pub fn lines(&self) -> impl Iterator<Item = CsvLine<'_>> {
        let filled = self.records.iter().filter(|record| !is_blank(record));
        filled.map(|record| CsvLine { file: self, record })
    }

    /// All rows, at least one. Their numbers are finite. A blank line is no row and is refused.
    pub fn rows<R: DeserializeOwned + Columns>(&self) -> Result<Vec<R>, ExperimentError> {
        let row = |record: &StringRecord| {
            let bad = |reason: String| {
                let line = line(record);
                let reason = format!("line {line}: {reason}: correct that line, or measure again");
                ExperimentError::file(self.file, reason)
            };
            self.check_length(record)?;
            if let Some(column) = self.non_finite::<R>(record) {
                return Err(bad(format!("{column}: expected a finite number")));
            }
            record
                .deserialize(Some(&self.header))
                .map_err(|error| bad(csv_error_text(&error, &self.header)))
        };
        let rows: Vec<R> = self.records.iter().map(row).collect::<Result<_, _>>()?;
        if rows.is_empty() {
            return Err(ExperimentError::file(self.file, "holds no row: name a record with rows"));
        }
        Ok(rows)
    }

    /// The first column of numbers in which a line has an infinite number or none.
    fn non_finite<R: Columns>(&self, record: &StringRecord) -> Option<&'static str> {
        let is_non_finite = |column: &&Column| {
            let number =
                self.place(column.name).and_then(|index| record.get(index)?.parse::<f64>().ok());
            number.is_some_and(|number| !number.is_finite())
        };
        let mut numbers = R::COLUMNS.iter().filter(|column| column.kind == ColumnKind::Real);
        Some(numbers.find(is_non_finite)?.name)
    }
}

impl CsvLine<'_> {
    /// The field of a column; empty without that column.
    pub fn text(&self, column: &str) -> &str {
        let place = self.file.place(column);
        place.and_then(|place| self.record.get(place)).unwrap_or_default().trim()
    }

    /// Returns a number that satisfies `fits`.
    pub fn number<T: FromStr>(
        &self,
        column: &str,
        expected: &str,
        fits: impl Fn(&T) -> bool,
    ) -> Result<T, ExperimentError> {
        let number = self.text(column).parse().ok();
        number.filter(fits).ok_or_else(|| self.bad(column, expected))
    }

    pub fn bad(&self, column: &str, expected: &str) -> ExperimentError {
        let (line, found) = (line(self.record), self.text(column));
        let reason = format!("line {line}: {column} is {found:?}: it must be {expected}");
        ExperimentError::file(self.file.file, reason)
    }
}

/// The record with its texts as they were before they were written as fields.
fn unquoted(record: &StringRecord) -> StringRecord {
    let mut texts: StringRecord = record.iter().map(field_text).collect();
    texts.set_position(record.position().cloned());
    texts
}

fn is_blank(record: &StringRecord) -> bool {
    record.iter().all(|field| field.trim().is_empty())
}

fn line(record: &StringRecord) -> u64 {
    record.position().map_or(0, Position::line)
}
