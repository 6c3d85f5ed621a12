//! A CSV file with named columns, the format of the world files.

use std::fs;
use std::path::{Path, PathBuf};

use super::BarnError;

/// The columns and rows of a file, all as text.
pub(super) struct Table {
    file: PathBuf,
    columns: Vec<String>,
    rows: Vec<(usize, Vec<String>)>,
}

/// A row of a table.
pub(super) struct TableRow<'a> {
    table: &'a Table,
    line: usize,
    fields: &'a [String],
}

/// A column of the table.
#[derive(Clone, Copy)]
pub(super) struct Column {
    name: &'static str,
    place: usize,
}

impl Table {
    /// Reads a file; see [`Table::parse`].
    pub fn read(file: &Path) -> Result<Self, BarnError> {
        let unreadable = |reason: String| BarnError::Unreadable { file: file.to_owned(), reason };
        let bytes = fs::read(file).map_err(|error| unreadable(error.to_string()))?;
        let text = String::from_utf8(bytes).map_err(|_| unreadable("it is no text".to_owned()))?;
        Self::parse(&text, file)
    }

    /// Parses the text of a file; blank lines are skipped.
    pub fn parse(text: &str, file: &Path) -> Result<Self, BarnError> {
        let mut lines = text
            .trim_start_matches('\u{feff}')
            .lines()
            .enumerate()
            .map(|(index, line)| (index + 1, fields(line)))
            .filter(|(_, fields)| fields.iter().any(|field| !field.is_empty()));
        let columns = lines.next().map(|(_, fields)| fields).unwrap_or_default();
        let table = Self { file: file.to_owned(), rows: lines.collect(), columns };
        let expected = table.columns.len();
        match table.rows.iter().find(|(_, row)| row.len() != expected) {
            None => Ok(table),
            Some(&(line, ref row)) => {
                Err(BarnError::BadRow { file: table.file, line, found: row.len(), expected })
            }
        }
    }

    pub fn column(&self, name: &'static str) -> Result<Column, BarnError> {
        self.optional_column(name)
            .ok_or_else(|| BarnError::NoColumn { file: self.file.clone(), column: name })
    }

    pub fn optional_column(&self, name: &'static str) -> Option<Column> {
        let place = self.columns.iter().position(|column| column == name)?;
        Some(Column { name, place })
    }

    pub fn rows(&self) -> impl Iterator<Item = TableRow<'_>> {
        self.rows.iter().map(|(line, fields)| TableRow { table: self, line: *line, fields })
    }
}

fn fields(line: &str) -> Vec<String> {
    line.split(',').map(|field| field.trim().to_owned()).collect()
}

impl TableRow<'_> {
    /// Returns a number that satisfies `fits`.
    pub fn real(
        &self,
        column: Column,
        expected: &'static str,
        fits: impl Fn(f64) -> bool,
    ) -> Result<f64, BarnError> {
        let number = self.text(column).parse().ok();
        number.filter(|&number| fits(number)).ok_or_else(|| self.bad(column, expected))
    }

    /// Returns a number that satisfies `fits`; none for an empty field.
    pub fn optional_real(
        &self,
        column: Column,
        expected: &'static str,
        fits: impl Fn(f64) -> bool,
    ) -> Result<Option<f64>, BarnError> {
        if self.text(column).is_empty() {
            return Ok(None);
        }
        self.real(column, expected, fits).map(Some)
    }

    /// Returns a whole number.
    pub fn whole(&self, column: Column) -> Result<u32, BarnError> {
        let whole = "a whole number, 0 to 4294967295";
        let number = self.text(column).parse();
        number.map_err(|_| self.bad(column, whole))
    }

    pub fn text(&self, column: Column) -> &str {
        &self.fields[column.place]
    }

    pub fn bad(&self, column: Column, expected: &'static str) -> BarnError {
        BarnError::BadField {
            file: self.table.file.clone(),
            line: self.line,
            column: column.name,
            found: self.text(column).to_owned(),
            expected,
        }
    }
}
