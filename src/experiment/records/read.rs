//! From the bytes of a file to rows.

use std::collections::BTreeSet;
use std::path::Path;

use csv::{Position, ReaderBuilder, StringRecord};
use serde::de::DeserializeOwned;

use super::{Record, RecordError, Rows};
use crate::bench::DensityRow;
use crate::bench::columns::said;
use crate::experiment::campaign::SETTINGS;
use crate::experiment::missions::MissionRow;
use crate::experiment::{ABLATION_VARIANTS, SOAK_SETUP, ablation_rows, closed_loop_of_record};

/// The record that a CSV file holds, whatever further columns it has; those that older records lack may be missing. The
/// file's name is for messages.
///
/// # Errors
/// When the columns are those of no record, a row cannot be read, or there is none.
pub fn read_record(bytes: &[u8], file: &Path) -> Result<Record, RecordError> {
    let lines = Lines::of(bytes, file)?;
    let has = |columns: &[&str]| {
        let mut wanted = columns.iter();
        wanted.all(|wanted| lines.header.iter().any(|column| column == *wanted))
    };
    // What no other record has.
    let rows = if has(&["engine", "samples", "p99_ms"]) {
        Rows::Density(lines.rows()?.into_iter().map(named).collect())
    } else if has(&["window_s", "samples", "regret_p50"]) {
        Rows::Quality(lines.rows()?)
    } else if has(&["world", "seed", "blame"]) {
        Rows::DynaBarn(lines.rows()?)
    } else if has(&["world", "seed", "score"]) {
        Rows::Barn(lines.rows()?)
    } else if has(&["kind", "samples", "mean_shared_time_s"]) {
        Rows::Sweep(lines.rows()?)
    } else if has(&["setup", "map", "seed"]) {
        missions(lines.rows()?, file)?
    } else {
        let file = file.to_owned();
        return Err(RecordError::OtherColumns { file });
    };
    let settings = lines.settings();
    Ok(Record { rows, settings })
}

/// Missions by what they were driven for, which the names of their settings tell.
fn missions(rows: Vec<MissionRow>, file: &Path) -> Result<Rows, RecordError> {
    let are = |is: &dyn Fn(&str) -> bool| rows.iter().all(|row| is(&row.setup));
    let is_variant = |name: &str| ABLATION_VARIANTS.iter().any(|one| one.name == name);
    if are(&|name| name == SOAK_SETUP) {
        return Ok(Rows::Soak(rows));
    }
    if are(&is_variant) {
        return Ok(Rows::Ablation(ablation_rows(
            &rows.iter().collect::<Vec<_>>(),
        )));
    }
    let no_sampling = |setup| RecordError::NoSampling {
        file: file.to_owned(),
        setup,
    };
    Ok(Rows::ClosedLoop(
        closed_loop_of_record(&rows).map_err(no_sampling)?,
    ))
}

/// A row with a name: the oldest records have none.
fn named(mut row: DensityRow) -> DensityRow {
    if row.name.is_empty() {
        let plural = if row.threads == 1 { "" } else { "s" };
        let cpu = || format!("CPU, {} thread{plural}", row.threads);
        row.name = row.adapter.clone().unwrap_or_else(cpu);
    }
    row
}

/// A file's lines as text, all as long as the first.
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
        let bad = |line, reason| RecordError::BadRow {
            file: file.to_owned(),
            line,
            reason,
        };
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
        Ok(Self {
            file,
            header,
            records,
        })
    }

    /// All rows, at least one.
    fn rows<R: DeserializeOwned>(&self) -> Result<Vec<R>, RecordError> {
        let file = || self.file.to_owned();
        let row = |record: &StringRecord| {
            record
                .deserialize(Some(&self.header))
                .map_err(|error| RecordError::BadRow {
                    file: file(),
                    line: line(record),
                    reason: said(&error, &self.header),
                })
        };
        let rows: Vec<R> = self.records.iter().map(row).collect::<Result<_, _>>()?;
        if rows.is_empty() {
            return Err(RecordError::NoRow { file: file() });
        }
        Ok(rows)
    }

    fn settings(&self) -> Vec<String> {
        let place = self.header.iter().position(|column| column == SETTINGS);
        let fields = |place| {
            self.records
                .iter()
                .filter_map(move |record| record.get(place))
        };
        let once: BTreeSet<&str> = place.into_iter().flat_map(fields).collect();
        once.into_iter().map(str::to_owned).collect()
    }
}

fn line(record: &StringRecord) -> usize {
    record.position().map_or(0, Position::line) as usize
}
