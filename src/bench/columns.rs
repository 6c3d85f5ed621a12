//! Columns of result tables. A row type declares each column once; CSV, Parquet and text tables are made from that declaration.

use csv::{ErrorKind, StringRecord, Writer};
use serde::Serialize;
use serde_json::Value;

/// Type of the values in a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ColumnKind {
    /// A string or the name of an enum's variant.
    Text,
    /// A whole number.
    Integer,
    /// A real number.
    Real,
    /// A truth value.
    Bool,
}

/// One column of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Column {
    /// The field's name, which ends in its unit: `time_s`, `speed_m_s`.
    pub name: &'static str,
    /// Type of its values.
    pub kind: ColumnKind,
    /// Decimals in text tables; all digits if it is none.
    pub digits: Option<usize>,
    /// The field's doc comment.
    pub doc: &'static str,
}

/// Names whose ending is no unit of [`UNITS`], each with its heading and its unit.
const NAMES: [(&str, &str, Option<&str>); 5] = [
    ("steps_per_s", "rate", Some("steps/s")),
    ("angle_per_m", "angle", Some("rad/m")),
    ("missed_20_hz", "missed at 20 Hz", None),
    ("missed_50_hz", "missed at 50 Hz", None),
    ("missed_100_hz", "missed at 100 Hz", None),
];

/// Endings of names and the units that they mean; the first that fits counts.
const UNITS: [(&str, &str); 13] = [
    ("_m_s2", "m/s^2"),
    ("_m_s3", "m/s^3"),
    ("_j_per_kg", "J/kg"),
    ("_per_m", "1/m"),
    ("_rad_s", "rad/s"),
    ("_m_s", "m/s"),
    ("_rad", "rad"),
    ("_ms", "ms"),
    ("_us", "us"),
    ("_hz", "Hz"),
    ("_m", "m"),
    ("_s", "s"),
    ("_share", "share"),
];

impl Column {
    /// The unit, from the name's ending; none for a number without one.
    #[must_use]
    pub fn unit(&self) -> Option<&'static str> {
        self.split().1
    }

    /// The heading in a text table or on a page: `mean time, s`.
    #[must_use]
    pub fn heading(&self) -> String {
        let (name, unit) = self.split();
        let name = name.replace('_', " ");
        match unit {
            Some(unit) if unit != "share" => format!("{name}, {unit}"),
            _ => name,
        }
    }

    fn split(&self) -> (&'static str, Option<&'static str>) {
        if let Some((_, heading, unit)) = NAMES.iter().find(|(name, ..)| *name == self.name) {
            return (heading, *unit);
        }
        let fits = |&(ending, unit)| Some((self.name.strip_suffix(ending)?, Some(unit)));
        UNITS.iter().find_map(fits).unwrap_or((self.name, None))
    }

    /// A value of this column for people; `-` for a missing one.
    #[must_use]
    pub fn text(&self, value: &Value) -> String {
        match (value, self.digits) {
            (Value::Null, _) => "-".to_owned(),
            (Value::String(text), _) => text.clone(),
            (Value::Bool(is), _) => if *is { "yes" } else { "no" }.to_owned(),
            (number, Some(digits)) => match number.as_f64() {
                Some(number) => format!("{number:.digits$}"),
                None => number.to_string(),
            },
            (other, None) => other.to_string(),
        }
    }
}

/// A type that a column can have.
pub trait ColumnValue {
    /// The column's type.
    const KIND: ColumnKind;
}

impl<T: ColumnValue> ColumnValue for Option<T> {
    const KIND: ColumnKind = T::KIND;
}

macro_rules! column_values {
    ($($kind:ident: $($value:ty),+;)+) => {
        $($(impl $crate::bench::ColumnValue for $value {
            const KIND: $crate::bench::ColumnKind = $crate::bench::ColumnKind::$kind;
        })+)+
    };
}
pub(crate) use column_values;

column_values! {
    Text: String, &'static str;
    Integer: u32, u64, usize;
    Real: f64;
    Bool: bool;
}

/// A flat record of numbers and texts.
pub trait Columns: Serialize {
    /// Its columns, in the order of its fields.
    const COLUMNS: &[Column];
}

/// Declares a row type: a struct whose fields are its columns. `=> 3` after a type gives the decimals in text tables.
macro_rules! columns {
    (
        $(#[$about:meta])*
        pub struct $name:ident {
            $($(#[doc = $doc:literal])+ $(#[serde($serde:meta)])? pub $field:ident: $value:ty $(=> $digits:literal)?,)+
        }
    ) => {
        $(#[$about])*
        pub struct $name {
            $($(#[doc = $doc])+ $(#[serde($serde)])? pub $field: $value,)+
        }

        impl $crate::bench::Columns for $name {
            const COLUMNS: &[$crate::bench::Column] = &[$($crate::bench::Column {
                name: stringify!($field),
                kind: <$value as $crate::bench::ColumnValue>::KIND,
                digits: <[usize]>::first(&[$($digits)?]).copied(),
                doc: concat!($($doc),+).trim_ascii(),
            },)+];
        }
    };
}
pub(crate) use columns;

/// A CSV file of rows: a line with the names of the columns, then a line for each row.
#[must_use]
pub fn csv_text<R: Columns>(rows: &[R]) -> String {
    let header = csv_line(R::COLUMNS.iter().map(|column| column.name));
    let lines = rows.iter().map(|row| {
        let record = record(row);
        csv_line(R::COLUMNS.iter().map(|column| csv_field(&record[column.name])))
    });
    header + &lines.collect::<String>()
}

/// The columns of these names, which are separated by spaces.
pub(crate) fn named_columns<R: Columns>(names: &str) -> Vec<&'static Column> {
    let of_name = |name: &str| R::COLUMNS.iter().find(|column| column.name == name);
    names.split_whitespace().filter_map(of_name).collect()
}

/// Width of a terminal that a text table should fit into, characters.
const TERMINAL_WIDTH: usize = 100;

/// A text table of some columns, whose names are separated by spaces: headings, then a line for each row. Texts are aligned
/// left, numbers right. A column without any value is left out. The headings of a wide table have several lines.
#[must_use]
pub fn text_table<R: Columns>(rows: &[R], names: &str) -> Vec<String> {
    let mut columns = named_columns::<R>(names);
    let records: Vec<Value> = rows.iter().map(record).collect();
    columns.retain(|column| {
        records.is_empty() || records.iter().any(|record| !record[column.name].is_null())
    });
    let text =
        |record: &Value| columns.iter().map(|column| column.text(&record[column.name])).collect();
    let rows: Vec<Vec<String>> = records.iter().map(text).collect();
    let is_text = |place: usize| columns[place].kind == ColumnKind::Text;
    let with_headings =
        |headings: Vec<Vec<String>>| aligned(&[headings, rows.clone()].concat(), is_text);
    let headings: Vec<String> = columns.iter().map(|column| column.heading()).collect();
    let lines = with_headings(vec![headings.clone()]);
    if lines.iter().all(|line| line.chars().count() <= TERMINAL_WIDTH) {
        return lines;
    }
    let width = |place: usize| rows.iter().map(|row| row[place].chars().count()).max();
    let stacks: Vec<Vec<String>> = headings
        .iter()
        .enumerate()
        .map(|(place, heading)| stacked(heading, width(place).unwrap_or(0)))
        .collect();
    let height = stacks.iter().map(Vec::len).max().unwrap_or(0);
    // They stand on the first row.
    let line = |number: usize| {
        let cell = |stack: &Vec<String>| {
            (number + stack.len())
                .checked_sub(height)
                .map_or_else(String::new, |at| stack[at].clone())
        };
        stacks.iter().map(cell).collect()
    };
    with_headings((0..height).map(line).collect())
}

/// The words of a heading in lines that are no wider than the values, or than its longest word.
fn stacked(heading: &str, values_width: usize) -> Vec<String> {
    let words = heading.split(' ');
    let longest = words.clone().map(|word| word.chars().count()).max().unwrap_or(0);
    wrapped(words, values_width.max(longest))
}

/// Words in lines of at most this number of characters; a longer word has a line of its own.
pub(crate) fn wrapped<'a>(words: impl Iterator<Item = &'a str>, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in words {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= width => {
                *line += " ";
                *line += word;
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// Aligns the cells of lines: columns of text left, columns of numbers right.
pub(crate) fn aligned(lines: &[Vec<String>], is_text: impl Fn(usize) -> bool) -> Vec<String> {
    let width = |place: usize| lines.iter().map(|line| line[place].chars().count()).max();
    let columns = lines.first().map_or(0, Vec::len);
    let widths: Vec<usize> = (0..columns).filter_map(width).collect();
    let line = |cells: &Vec<String>| {
        let padded = cells.iter().zip(&widths).enumerate().map(|(place, (cell, &width))| {
            if is_text(place) { format!("{cell:width$}") } else { format!("{cell:>width$}") }
        });
        let text = padded.collect::<Vec<_>>().join("  ");
        text.trim_end().to_owned()
    };
    lines.iter().map(line).collect()
}

/// A row as a JSON object.
fn record<R: Columns>(row: &R) -> Value {
    // A flat record always serialises; its line would be empty otherwise.
    serde_json::to_value(row).unwrap_or_default()
}

fn csv_field(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(text) => text_field(text),
        other => other.to_string(),
    }
}

/// Characters that begin a formula in a spreadsheet.
const FORMULA_STARTS: [char; 4] = ['=', '+', '-', '@'];

/// A text as a field: it stays on its line, and an apostrophe keeps a spreadsheet from running it as a formula.
fn text_field(text: &str) -> String {
    let line = text.replace(['\n', '\r', '\t'], " ");
    let unquoted = line.trim_start_matches('\'');
    let is_formula = unquoted.len() > 1 && unquoted.starts_with(FORMULA_STARTS);
    if is_formula { format!("'{line}") } else { line }
}

/// The text of a field as [`csv_text`] writes it, without the apostrophe before a formula.
pub(crate) fn field_text(field: &str) -> &str {
    let text = field.strip_prefix('\'').unwrap_or(field);
    let is_formula = text.trim_start_matches('\'').starts_with(FORMULA_STARTS);
    if is_formula { text } else { field }
}

/// One line of a CSV file, with its end.
pub(crate) fn csv_line(fields: impl IntoIterator<Item: AsRef<[u8]>>) -> String {
    let mut writer = Writer::from_writer(Vec::new());
    // Writing to memory does not fail.
    let _ = writer.write_record(fields);
    let bytes = writer.into_inner().unwrap_or_default();
    String::from_utf8_lossy(&bytes).into_owned()
}

/// What is wrong with a row of a CSV file, by the name of the column.
pub(crate) fn csv_error_text(error: &csv::Error, header: &StringRecord) -> String {
    match error.kind() {
        ErrorKind::Deserialize { err, .. } => {
            let column = err.field().and_then(|field| header.get(field as usize));
            format!("{}: {}", column.unwrap_or("the row"), err.kind())
        }
        _ => error.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    columns! {
        /// A row.
        #[derive(Serialize)]
        pub struct Row {
            /// Its name.
            pub name: Option<String>,
            /// Its speed.
            pub mean_speed_m_s: f64 => 2,
            /// A count.
            pub runs: u32,
        }
    }

    fn rows() -> Vec<Row> {
        let row = |name: Option<&str>, mean_speed_m_s, runs| Row {
            name: name.map(str::to_owned),
            mean_speed_m_s,
            runs,
        };
        vec![row(Some("a,\nb"), 1.005, 7), row(None, 12.0, 1234)]
    }

    #[test]
    fn text_table_aligns_numbers_right() {
        let named = |name: &str| Row { name: Some(name.to_owned()), ..rows().remove(1) };
        assert_eq!(
            text_table(&[named("b")], "name mean_speed_m_s runs"),
            ["name  mean speed, m/s  runs", "b               12.00  1234"]
        );
        assert_eq!(
            text_table(&rows()[1..], "name mean_speed_m_s runs"),
            ["mean speed, m/s  runs", "          12.00  1234"],
            "a column without a value is left out"
        );
    }

    #[test]
    fn headings_of_a_wide_table_are_stacked() {
        let names = "name mean_speed_m_s runs ".repeat(5);
        let lines = text_table(&rows()[1..], &names);
        assert_eq!(lines.len(), 4, "{lines:#?}");
        assert!(lines[0].starts_with("  mean        "), "{lines:#?}");
        assert!(lines[1].starts_with("speed,        "), "{lines:#?}");
        assert!(lines[2].starts_with("   m/s  runs  "), "{lines:#?}");
        assert!(lines[3].starts_with(" 12.00  1234  "), "{lines:#?}");
        assert!(lines.iter().all(|line| line.len() <= TERMINAL_WIDTH), "{lines:#?}");
    }

    #[test]
    fn csv_quotes_commas_and_keeps_rows_on_one_line() {
        assert_eq!(csv_text(&rows()), "name,mean_speed_m_s,runs\n\"a, b\",1.005,7\n,12.0,1234\n");
        assert_eq!(Row::COLUMNS[1].doc, "Its speed.");
        assert_eq!(Row::COLUMNS[1].unit(), Some("m/s"));
    }

    #[test]
    fn names_that_end_like_a_unit_have_a_heading_of_their_own() {
        let heading = |name| Column { name, ..Row::COLUMNS[2] }.heading();
        assert_eq!(heading("steps_per_s"), "rate, steps/s");
        assert_eq!(heading("angle_per_m"), "angle, rad/m");
        assert_eq!(heading("missed_20_hz"), "missed at 20 Hz");
        assert_eq!(heading("omega_sign_changes_per_m"), "omega sign changes, 1/m");
    }

    #[test]
    fn formulas_are_quoted_and_read_back() {
        for (text, field) in [
            ("=1+cmd", "'=1+cmd"),
            ("'=1", "''=1"),
            ("@sum", "'@sum"),
            ("-", "-"),
            ("mine's", "mine's"),
            ("'a", "'a"),
        ] {
            assert_eq!(text_field(text), field);
            assert_eq!(field_text(field), text);
        }
    }
}
