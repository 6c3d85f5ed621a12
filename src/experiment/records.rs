//! Reads records of benchmarks and experiments. The columns determine the kind of the record.

use std::collections::BTreeSet;
use std::path::Path;

use super::csv_file::CsvFile;
use super::{
    ABLATION_VARIANTS, ExperimentError, Group, RunRow, WorldKind, ablation_groups, groups,
};
use crate::bench::{DensityRow, QualityRow};
use crate::local::Sampler;

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
        // `bench density` names the settings of a sampler other than arcs after it.
        let has_sampler = |row: &RunRow| {
            let mut names = Sampler::ALL.iter().map(|sampler| sampler.name());
            row.weights.is_none()
                && row.config.as_deref().is_none_or(|config| names.any(|name| name == config))
        };
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
        } else if are(WorldKind::Missions) && all(&has_sampler) {
            let mut groups = groups(&rows);
            // As `bench density` orders them: by samples, then arcs before other samplers.
            groups.sort_by_key(|group| {
                let (sampler, vx_samples) = (group.config.clone(), group.vx_samples);
                (group.samples, sampler, core::cmp::Reverse(vx_samples))
            });
            Self::ClosedLoop(groups)
        } else {
            Self::Sweep(groups(&rows))
        }
    }
}

/// Reads the record that a CSV file contains. Further columns are ignored; columns that older records lack may be missing.
/// The file's name is for messages.
///
/// # Errors
/// Fails when the columns are those of no record, a row cannot be read, or there is none.
pub fn read_record(bytes: &[u8], file: &Path) -> Result<Record, ExperimentError> {
    let text = String::from_utf8_lossy(bytes);
    if text.trim_start().starts_with(['[', '{']) {
        let reason = "it is a JSON record: name a CSV record, which --record FILE.csv and --record-... FILE.csv write";
        return Err(ExperimentError::file(file, reason));
    }
    let lines = CsvFile::parse(&text, file)?;
    let has = |columns: &[&str]| lines.lacks(columns).is_none();
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
        let reason = "line 1 has not the columns of a record that can be drawn: name a CSV record of `bench density`, \
            `bench barn`, `bench dynabarn`, `bench soak` or `bench ablation`, or a table of `sweep merge`";
        Err(ExperimentError::file(file, reason))
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
