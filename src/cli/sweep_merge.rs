//! `inbye sweep merge`.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Args;
use inbye::bench::{Columns, csv_text};
use inbye::experiment::sweep::{Manifest, Merged, SweepError, SweepGroup, groups, merge};
use inbye::report::{BenchReport, bench_files};
use serde_json::json;

use super::{output, report_file, sweep_folder};

/// Folder of the table and the report, where none is named.
const FOLDER: &str = "inbye-sweep-report";
/// Missing cells that are named.
const NAMED: usize = 3;

/// `inbye sweep merge`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  inbye sweep merge cells --report merged\n\n\
    The folders are those of `inbye sweep --out`, all of one plan. `sweep.csv` and `sweep.parquet` have a row for each cell, in \
    the order of the plan, and are the same bytes whoever ran the cells. `latency.csv` and `latency.parquet` have what the \
    clocks said of latency cells. `index.html` shows success and time, and opens without a network.\n\
    JSON fields: `cells`, `missing`, `groups`.\n\
    Exit status 1: a cell is missing; the rows that are there are written all the same.")]
pub struct MergeArguments {
    /// The folders of results.
    #[arg(required = true, value_name = "DIR")]
    pub folders: Vec<PathBuf>,
    /// Write tables and report into this folder [default: inbye-sweep-report].
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
}

/// Merges. False when a cell is missing.
pub fn run(arguments: &MergeArguments, json: bool) -> anyhow::Result<bool> {
    let (manifest, merged) = read(&arguments.folders)?;
    let folder = arguments.report.as_deref().unwrap_or(Path::new(FOLDER));
    write(folder, &manifest, &merged)?;
    let groups = groups(&merged.rows);
    let (cells, missing) = (manifest.keys().len(), &merged.missing);
    if json {
        output::json(&json!({ "cells": cells, "missing": missing, "groups": groups }))?;
    } else {
        for group in &groups {
            output::line(words(group));
        }
        if !missing.is_empty() {
            let named: Vec<&str> = missing.iter().take(NAMED).map(String::as_str).collect();
            output::line(format!(
                "{} of {cells} cells are missing, such as {}",
                missing.len(),
                named.join(", ")
            ));
        }
    }
    Ok(missing.is_empty())
}

/// The plan, and the results of all folders together.
fn read(folders: &[PathBuf]) -> anyhow::Result<(Manifest, Merged)> {
    let mut first: Option<(&PathBuf, Manifest)> = None;
    let mut files = Vec::new();
    for folder in folders {
        let (manifest, cells) = sweep_folder::read(folder)?;
        files.extend(cells);
        match &first {
            None => first = Some((folder, manifest)),
            Some((_, known)) if *known == manifest => {}
            Some((place, known)) => {
                let other = SweepError::OtherPlan {
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

fn write(folder: &Path, manifest: &Manifest, merged: &Merged) -> anyhow::Result<()> {
    report_file::create_folder(folder)?;
    table(folder, "sweep", &merged.rows)?;
    if !merged.latencies.is_empty() {
        table(folder, "latency", &merged.latencies)?;
    }
    let intro = match (manifest.cells.len(), merged.rows.len()) {
        (all, there) if all == there => format!("{all} cells."),
        (all, there) => format!("{there} of {all} cells; the others have no result yet."),
    };
    let files = bench_files(&BenchReport {
        title: &manifest.title,
        intro: &intro,
        command: "inbye sweep PLAN.toml --out DIR\ninbye sweep merge DIR",
        sweep: &groups(&merged.rows),
        sweep_latency: &merged.latencies,
        ..BenchReport::default()
    });
    report_file::write_files(folder, &files)
}

/// A table as CSV, and as Parquet where that is built in.
fn table<R: Columns>(folder: &Path, name: &str, rows: &[R]) -> anyhow::Result<()> {
    let file = |ending: &str, bytes: &[u8]| {
        let file = folder.join(format!("{name}.{ending}"));
        fs::write(&file, bytes).with_context(|| file.display().to_string())
    };
    file("csv", csv_text(rows).as_bytes())?;
    #[cfg(feature = "parquet")]
    file("parquet", &inbye::experiment::sweep::parquet_bytes(rows)?)?;
    Ok(())
}

/// A group in a line.
fn words(group: &SweepGroup) -> String {
    let name = |name: &Option<String>| name.clone().unwrap_or_else(|| "-".to_owned());
    let seconds = |time_s: Option<f64>| {
        time_s.map_or_else(|| "-".to_owned(), |time_s| format!("{time_s:.2}"))
    };
    format!(
        "{:9} {:12} {:12} {:8} {:>4}x{:<4} {:5} of {:5} reached, {:4} contacts, time {:>7} s, over {} shared {:>7} s",
        group.kind.name(),
        name(&group.config),
        name(&group.weights),
        group.engine,
        group.vx_samples,
        group.vtheta_samples,
        group.reached,
        group.runs,
        group.contacts,
        seconds(group.mean_time_s),
        group.shared,
        seconds(group.mean_shared_time_s),
    )
}
