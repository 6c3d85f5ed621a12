//! `inbye sweep merge`.

use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Args;
use inbye::bench::{Columns, text_table};
use inbye::experiment::{ExperimentError, Group, Manifest, Merged, RunRow, faults, groups, merge};
use inbye::report::{BenchReport, bench_files};
use serde_json::json;

use super::files::{Output, ReportFolder, all_written};
use super::runs::fault_lines;
use super::{output, result_store};

/// Default folder of the table and the report.
const FOLDER: &str = "inbye-sweep-report";
/// Number of missing cells that are named.
const NAMED: usize = 3;

/// `inbye sweep merge`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  inbye sweep merge cells --report merged\n\n\
    The folders are those of `inbye sweep --out` or of --out of a benchmark, all of one plan. `sweep.csv` and `sweep.parquet` \
    have a row for each cell, in the order of the plan, and are the same bytes on every machine. `latency.csv` and \
    `latency.parquet` have the rows of latency cells with their times. `index.html` shows success and time, and opens without \
    a network.\n\
    JSON fields: `cells`, `missing`, `groups`.\n\
    Exit status 1: a cell is missing; the rows of the other cells are written.")]
pub struct MergeArguments {
    /// The folders of results.
    #[arg(required = true, value_name = "DIR")]
    pub folders: Vec<PathBuf>,
    /// Write tables and report into this folder [default: inbye-sweep-report].
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
}

/// Merges. Returns false when a cell is missing.
pub fn run(arguments: &MergeArguments) -> anyhow::Result<bool> {
    let (manifest, Merged { rows, missing, .. }) = read(&arguments.folders)?;
    let folder = arguments.report.as_deref().unwrap_or(Path::new(FOLDER));
    let intro = match (manifest.cells.len(), rows.len()) {
        (all, there) if all == there => format!("{all} cells."),
        (all, there) => format!("{there} of {all} cells; the others have no result yet."),
    };
    let latencies: Vec<RunRow> = rows.iter().filter(|row| row.latency).cloned().collect();
    // Without times the rows are the same bytes on every machine.
    let rows: Vec<RunRow> = rows.into_iter().map(RunRow::without_clock).collect();
    let groups = groups(&rows);
    let report = ReportFolder::create(Some(folder))?;
    let sweep_table = table(folder, "sweep", &rows);
    // The rows of an earlier merge do not stay beside those of this one.
    let has_latency = !latencies.is_empty() || folder.join("latency.csv").exists();
    let latency_table = if has_latency { table(folder, "latency", &latencies) } else { Ok(()) };
    let reported = report.write(|| {
        bench_files(&BenchReport {
            title: &manifest.title,
            intro: &intro,
            command: "inbye sweep PLAN.toml --out DIR\ninbye sweep merge DIR",
            sweep: &groups,
            sweep_latency: &latencies,
            ..BenchReport::default()
        })
    });
    let cells = manifest.keys().len();
    let mut lines = text_table(&groups, Group::SUMMARY);
    lines.extend(fault_lines(&faults(&rows)));
    if !missing.is_empty() {
        let named = missing[..NAMED.min(missing.len())].join(", ");
        lines.push(format!("{} of {cells} cells are missing, such as {named}", missing.len()));
    }
    let object = json!({ "cells": cells, "missing": missing, "groups": groups });
    output::result(&object, lines)?;
    all_written([sweep_table, latency_table, reported])?;
    Ok(missing.is_empty())
}

/// The manifest, and the results of all folders together.
fn read(folders: &[PathBuf]) -> anyhow::Result<(Manifest, Merged)> {
    let mut first: Option<(&PathBuf, Manifest)> = None;
    let mut files = Vec::new();
    for folder in folders {
        let (manifest, cells) = result_store::read(folder)?;
        files.extend(cells);
        match &first {
            None => first = Some((folder, manifest)),
            Some((_, known)) if *known == manifest => {}
            Some((place, known)) => {
                let other = ExperimentError::OtherPlan {
                    folders: [(*place).clone(), folder.clone()],
                    titles: [known.title.clone(), manifest.title.clone()],
                    cells: [known.cells.len(), manifest.cells.len()],
                };
                return Err(other.into());
            }
        }
    }
    let (_, manifest) = first.context("no folder to merge")?;
    let merged = merge(&manifest, files)?;
    Ok((manifest, merged))
}

/// Writes a table as CSV, and as Parquet in a build with the feature `parquet`.
fn table<R: Columns>(folder: &Path, name: &str, rows: &[R]) -> anyhow::Result<()> {
    let csv = folder.join(format!("{name}.csv"));
    Output::of_rows::<R>("--report", Some(&csv))?.write_rows(rows)?;
    #[cfg(feature = "parquet")]
    {
        let parquet = folder.join(format!("{name}.parquet"));
        let file = Output::create("--report", Some(&parquet), &["parquet"])?;
        let bytes = inbye::experiment::parquet_bytes(rows)?;
        file.write(|| bytes)?;
    }
    #[cfg(not(feature = "parquet"))]
    output::note(format!(
        "{name}.parquet: not written: this build, such as that of the Python wheel, has no feature `parquet`: use {name}.csv, a \
         package, or a build with `--features parquet`"
    ));
    Ok(())
}
