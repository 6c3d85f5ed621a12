//! The rows of a campaign, and the CSV file that keeps them.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::path::Path;

use csv::{Position, ReaderBuilder, StringRecord};
use serde::de::DeserializeOwned;

use super::CampaignError;
use crate::bench::Columns;
use crate::bench::columns::{csv_line, fields, said};

/// What one run leaves behind, every field of it in a column.
pub trait Row: Columns + DeserializeOwned + Send {
    /// What tells the run from all others of its campaign.
    type Key: Ord + Clone + Display;

    /// Which run it is of.
    fn key(&self) -> Self::Key;
}

/// The last column: the digest of the settings that a row was run with.
pub(in crate::experiment) const SETTINGS: &str = "settings";

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
        // Rows of another length are refused below, with their line.
        let mut reader = ReaderBuilder::new()
            .flexible(true)
            .from_reader(text.as_bytes());
        let header = StringRecord::from(columns::<R>());
        let bad = |error: csv::Error| CampaignError::BadRow {
            file: file.to_owned(),
            line: error.position().map_or(0, Position::line) as usize,
            reason: said(&error, &header),
        };
        if whole > 0 && *reader.headers().map_err(bad)? != header {
            return Err(CampaignError::OtherColumns {
                file: file.to_owned(),
                expected: csv_line(&header).trim_end().to_owned(),
            });
        }
        for record in reader.records() {
            ledger.take(&record.map_err(bad)?, &header, file)?;
        }
        Ok((ledger, whole))
    }

    fn take(
        &mut self,
        record: &StringRecord,
        header: &StringRecord,
        file: &Path,
    ) -> Result<(), CampaignError> {
        let line = record.position().map_or(0, Position::line) as usize;
        let bad = |reason: String| CampaignError::BadRow {
            file: file.to_owned(),
            line,
            reason,
        };
        let (found, expected) = (record.len(), header.len());
        if found != expected {
            return Err(bad(format!("{found} fields; expected {expected}")));
        }
        let settings = &record[expected - 1];
        if settings != self.settings {
            return Err(CampaignError::OtherSettings {
                file: file.to_owned(),
                line,
                found: settings.to_owned(),
                expected: self.settings.clone(),
            });
        }
        let row: R = record
            .deserialize(Some(header))
            .map_err(|error| bad(said(&error, header)))?;
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
        csv_line(columns::<R>())
    }

    /// The line of a row, with its end.
    #[must_use]
    pub fn line(&self, row: &R) -> String {
        csv_line(fields(row).chain([self.settings.clone()]))
    }

    /// The whole file, its rows in the order of their keys: the same whatever the order in which the runs finished.
    #[must_use]
    pub fn text(&self) -> String {
        let lines = self.rows().map(|row| self.line(row));
        self.header() + &lines.collect::<String>()
    }
}

fn columns<R: Row>() -> Vec<&'static str> {
    [R::COLUMNS, &[SETTINGS]].concat()
}
