//! Reads records of benchmarks and experiments. The columns determine the kind of the record.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use csv::{Position, ReaderBuilder, StringRecord};
use serde::de::DeserializeOwned;
use thiserror::Error;

use super::{ABLATION_VARIANTS, Group, RunRow, WorldKind, ablation_groups, groups};
use crate::bench::columns::csv_error_text;
use crate::bench::{Column, ColumnKind, Columns, DensityRow, QualityRow};

/// The rows of a file, in its order.
#[derive(Clone, Debug, PartialEq)]
pub enum Record {
    /// Latencies of `bench density --record`.
    Density(Vec<DensityRow>),
    /// Regrets of `bench density --record-quality`.
    Quality(Vec<QualityRow>),
    /// Missions with several samplings, a group for each.
    ClosedLoop(Vec<Group>),
    /// Runs of BARN.
    Barn(Vec<RunRow>),
    /// Runs of `DynaBARN`.
    DynaBarn(Vec<RunRow>),
    /// Missions with one set of settings.
    Soak(Vec<RunRow>),
    /// Missions of an ablation, a group for each variant.
    Ablation(Vec<Group>),
    /// Groups of a sweep.
    Sweep(Vec<Group>),
}

impl Record {
    /// Description of the record, as text for people.
    #[must_use]
    pub const fn title(&self) -> &'static str {
        match self {
            Self::Density(_) => "latencies",
            Self::Quality(_) => "regrets",
            Self::ClosedLoop(_) => "missions with several samplings",
            Self::Barn(_) => "BARN runs",
            Self::DynaBarn(_) => "DynaBARN runs",
            Self::Soak(_) => "missions of a soak",
            Self::Ablation(_) => "missions of an ablation",
            Self::Sweep(_) => "groups of a sweep",
        }
    }

    /// Returns the kind of record that runs are, from their worlds and settings.
    fn of_runs(rows: Vec<RunRow>) -> Self {
        let all = |is: &dyn Fn(&RunRow) -> bool| rows.iter().all(is);
        let are = |kind: WorldKind| all(&|row| row.kind == kind);
        let is_variant = |row: &RunRow| {
            let variants = ABLATION_VARIANTS.iter();
            row.config.is_some()
                && variants.map(|it| Some(it.name)).any(|it| it == row.config.as_deref())
        };
        let is_plain = |row: &RunRow| row.config.is_none() && row.weights.is_none();
        let samplings: BTreeSet<(u32, u32)> =
            rows.iter().map(|row| (row.vx_samples, row.vtheta_samples)).collect();
        let has_one_setup = samplings.len() == 1 && all(&is_plain);
        if are(WorldKind::Barn) && has_one_setup {
            Self::Barn(rows)
        } else if are(WorldKind::DynaBarn) && has_one_setup {
            Self::DynaBarn(rows)
        } else if are(WorldKind::Missions) && has_one_setup {
            Self::Soak(rows)
        } else if are(WorldKind::Missions) && all(&is_variant) {
            Self::Ablation(ablation_groups(&rows))
        } else if are(WorldKind::Missions) && all(&is_plain) {
            let mut groups = groups(&rows);
            groups.sort_by_key(|group| (group.samples, core::cmp::Reverse(group.vx_samples)));
            Self::ClosedLoop(groups)
        } else {
            Self::Sweep(groups(&rows))
        }
    }
}

/// A file that is no record.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum RecordError {
    /// The first line names the columns of no known record.
    #[error(
        "{}: line 1 has not the columns of a record that can be drawn: name a CSV record of `bench density`, `bench barn`, \
         `bench dynabarn`, `bench soak` or `bench ablation`, or a table of `sweep merge`", file.display()
    )]
    OtherColumns {
        /// The file.
        file: PathBuf,
    },
    /// A line that is no row.
    #[error("{}: line {line}: {reason}: correct that line, or measure again", file.display())]
    BadRow {
        /// The file.
        file: PathBuf,
        /// The line, from one.
        line: usize,
        /// What is wrong with it.
        reason: String,
    },
    /// No row below the names of the columns.
    #[error("{}: holds no row: name a record with rows", file.display())]
    NoRow {
        /// The file.
        file: PathBuf,
    },
}

/// Reads the record that a CSV file contains. Further columns are ignored; columns that older records lack may be missing.
/// The file's name is for messages.
///
/// # Errors
/// Fails when the columns are those of no record, a row cannot be read, or there is none.
pub fn read_record(bytes: &[u8], file: &Path) -> Result<Record, RecordError> {
    let lines = Lines::of(bytes, file)?;
    let has = |columns: &[&str]| {
        let mut wanted = columns.iter();
        wanted.all(|wanted| lines.header.iter().any(|column| column == *wanted))
    };
    // These columns occur in no other record.
    if has(&["engine", "samples", "p99_ms"]) {
        Ok(Record::Density(lines.rows()?.into_iter().map(named).collect()))
    } else if has(&["window_s", "samples", "regret_p50"]) {
        Ok(Record::Quality(lines.rows()?))
    } else if has(&["kind", "world", "seed", "outcome"]) {
        Ok(Record::of_runs(lines.rows()?))
    } else if has(&["kind", "samples", "mean_shared_time_s"]) {
        Ok(Record::Sweep(lines.rows()?))
    } else {
        let file = file.to_owned();
        Err(RecordError::OtherColumns { file })
    }
}

/// Gives a row its engine's name, which the oldest records lack.
fn named(mut row: DensityRow) -> DensityRow {
    if row.name.is_empty() {
        let plural = if row.threads == 1 { "" } else { "s" };
        let cpu = || format!("CPU, {} thread{plural}", row.threads);
        row.name = row.adapter.clone().unwrap_or_else(cpu);
    }
    row
}

/// The lines of a file as text, all with the number of fields of the first.
struct Lines<'a> {
    file: &'a Path,
    header: StringRecord,
    records: Vec<StringRecord>,
}

impl<'a> Lines<'a> {
    fn of(bytes: &[u8], file: &'a Path) -> Result<Self, RecordError> {
        let text = String::from_utf8_lossy(bytes);
        // Rows of another length are refused below, with their line.
        let mut reader = ReaderBuilder::new()
            .flexible(true)
            .from_reader(text.trim_start_matches('\u{feff}').as_bytes());
        let bad = |line, reason| RecordError::BadRow { file: file.to_owned(), line, reason };
        let unread = |error: csv::Error| {
            let line = error.position().map_or(1, Position::line);
            bad(line as usize, error.to_string())
        };
        let header = reader.headers().map_err(unread)?.clone();
        let mut records = Vec::new();
        for record in reader.records() {
            let record = record.map_err(unread)?;
            let (found, expected) = (record.len(), header.len());
            if found != expected {
                let reason = format!("{found} fields; expected {expected}");
                return Err(bad(line(&record), reason));
            }
            records.push(record);
        }
        Ok(Self { file, header, records })
    }

    /// All rows, at least one. Their numbers are finite.
    fn rows<R: DeserializeOwned + Columns>(&self) -> Result<Vec<R>, RecordError> {
        let file = || self.file.to_owned();
        let row = |record: &StringRecord| {
            let bad = |reason| RecordError::BadRow { file: file(), line: line(record), reason };
            if let Some(column) = self.non_finite::<R>(record) {
                return Err(bad(format!("{column}: expected a finite number")));
            }
            record
                .deserialize(Some(&self.header))
                .map_err(|error| bad(csv_error_text(&error, &self.header)))
        };
        let rows: Vec<R> = self.records.iter().map(row).collect::<Result<_, _>>()?;
        if rows.is_empty() {
            return Err(RecordError::NoRow { file: file() });
        }
        Ok(rows)
    }

    /// The first column of numbers in which a line has an infinite number or none.
    fn non_finite<R: Columns>(&self, record: &StringRecord) -> Option<&'static str> {
        let is_non_finite = |column: &&Column| {
            let index = self.header.iter().position(|name| name == column.name);
            let number = index.and_then(|index| record.get(index)?.parse::<f64>().ok());
            number.is_some_and(|number| !number.is_finite())
        };
        let mut numbers = R::COLUMNS.iter().filter(|column| column.kind == ColumnKind::Real);
        Some(numbers.find(is_non_finite)?.name)
    }
}

fn line(record: &StringRecord) -> usize {
    record.position().map_or(0, Position::line) as usize
}
