//! The rows of a campaign, and the CSV file that keeps them.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

use super::CampaignError;
use super::fields::{line, values};

/// What one run leaves behind: a flat record of numbers, texts and truths.
pub trait Row: Serialize + DeserializeOwned + Send {
    /// What tells the run from all others of its campaign.
    type Key: Ord + Clone + Display;

    /// The names of its fields, in the order of the file's columns.
    const COLUMNS: &[&str];

    /// Which run it is of.
    fn key(&self) -> Self::Key;
}

/// The last column: the digest of the settings that a row was run with.
const SETTINGS: &str = "settings";

/// The rows so far, by their keys.
#[derive(Clone, Debug)]
pub struct Ledger<R: Row> {
    settings: String,
    rows: BTreeMap<R::Key, R>,
}

impl<R: Row> Ledger<R> {
    /// An empty ledger for runs with settings of this digest.
    #[must_use]
    pub fn new(settings: &str) -> Self {
        Self {
            settings: settings.to_owned(),
            rows: BTreeMap::new(),
        }
    }

    /// A ledger of what a file held, and how many of its bytes are whole lines: what follows the last line break was torn
    /// off as it was written, and is to be cut away. An empty file is an empty ledger.
    ///
    /// # Errors
    /// When the header is another one, or a row was run with other settings, cannot be read, or is of a run that has one
    /// already.
    pub fn read(bytes: &[u8], file: &Path, settings: &str) -> Result<(Self, usize), CampaignError> {
        let whole = bytes
            .iter()
            .rposition(|&byte| byte == b'\n')
            .map_or(0, |last| last + 1);
        let mut ledger = Self::new(settings);
        let text = String::from_utf8_lossy(&bytes[..whole]);
        for (index, text) in text.lines().enumerate() {
            ledger.take_line(text, file, index + 1)?;
        }
        Ok((ledger, whole))
    }

    fn take_line(&mut self, text: &str, file: &Path, line: usize) -> Result<(), CampaignError> {
        let bad = |reason: String| CampaignError::BadRow {
            file: file.to_owned(),
            line,
            reason,
        };
        if line == 1 {
            let expected = header::<R>();
            let file = file.to_owned();
            return if text == expected {
                Ok(())
            } else {
                Err(CampaignError::OtherColumns { file, expected })
            };
        }
        let mut values = values(text).ok_or_else(|| bad("a quotation is not closed".to_owned()))?;
        let columns = R::COLUMNS.len() + 1;
        if values.len() != columns {
            let found = values.len();
            return Err(bad(format!("{found} fields; expected {columns}")));
        }
        let found = values.pop().map_or_else(String::new, plain);
        if found != self.settings {
            return Err(CampaignError::OtherSettings {
                file: file.to_owned(),
                line,
                found,
                expected: self.settings.clone(),
            });
        }
        let names = R::COLUMNS.iter().map(|&name| name.to_owned());
        let object: Map<String, Value> = names.zip(values).collect();
        let row: R = serde_json::from_value(Value::Object(object))
            .map_err(|error| bad(error.to_string()))?;
        let key = row.key();
        if self.rows.insert(key.clone(), row).is_some() {
            return Err(bad(format!("a second row of {key}")));
        }
        Ok(())
    }

    /// Whether a run has its row.
    #[must_use]
    pub fn has(&self, key: &R::Key) -> bool {
        self.rows.contains_key(key)
    }

    /// Adds the row of a run, in place of one that it has.
    pub fn add(&mut self, row: R) {
        self.rows.insert(row.key(), row);
    }

    /// The rows in the order of their keys.
    pub fn rows(&self) -> impl Iterator<Item = &R> {
        self.rows.values()
    }

    /// The first line of the file, with its end.
    #[must_use]
    pub fn header(&self) -> String {
        header::<R>() + "\n"
    }

    /// The line of a row, with its end.
    #[must_use]
    pub fn line(&self, row: &R) -> String {
        // A row is a flat record, which JSON has no trouble with; were it not, its line would be empty fields.
        let record = serde_json::to_value(row).unwrap_or_default();
        let settings = Value::String(self.settings.clone());
        let fields = R::COLUMNS.iter().map(|&name| &record[name]);
        line(fields.chain([&settings])) + "\n"
    }

    /// The whole file, its rows in the order of their keys: the same whatever the order in which the runs finished.
    #[must_use]
    pub fn text(&self) -> String {
        let lines = self.rows().map(|row| self.line(row));
        self.header() + &lines.collect::<String>()
    }
}

fn header<R: Row>() -> String {
    let mut columns = R::COLUMNS.to_vec();
    columns.push(SETTINGS);
    columns.join(",")
}

/// A field as it stands in the file, without quotation marks.
fn plain(value: Value) -> String {
    match value {
        Value::String(text) => text,
        Value::Null => String::new(),
        other => other.to_string(),
    }
}
