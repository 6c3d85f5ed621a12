//! `inbye sweep`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, ensure};
use clap::{Args, Subcommand};
use inbye::experiment::{
    Cell, ExperimentError, Grid, Manifest, Plan, RunOutcome, Shard, check_programs, faults,
};
use inbye::input_file::read_text;
use inbye::local::SharedEngines;
use inbye::runtime::{TomlError, parse_toml};
use inbye::suggest::counted;
use serde_json::{Value, json};

use super::arguments::whole;
use super::result_store::ResultStore;
use super::runs::{Done, Workers, fault_lines, run_alone};
use super::sweep_merge::{self, MergeArguments};
use super::{machine, output};

/// Folder of the results, where none is named.
const FOLDER: &str = "inbye-sweep";

/// `inbye sweep`.
#[derive(Debug, Args)]
#[command(
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    after_help = "Example:\n  inbye sweep --print-plan\n  inbye sweep sweep.toml --list\n  inbye sweep sweep.toml --out cells\n  \
    inbye sweep merge cells --report merged\n\n\
    Each combination of worlds, settings, weights, samplings, engines and seeds of the plan is a cell. Its result depends on \
    nothing else, and a digest of these inputs names its file: the same cell of another plan is not run again. The program may \
    be killed at any time and started again, and several processes may work on one folder, on one machine or on several that \
    share it: no cell is run twice. Where machines share no folder, run a --shard on each, and merge the folders.\n\
    Cells of worlds with `latency = true` run one at a time after the others, and no other cell on the same machine runs at \
    that time.\n\
    JSON fields: `cells`, `found`, `driven`, `errors`, `faults`, `left` [{`key`, `reason`}], `interrupted`, `out`; with --list `cells`, a list, in which \
    `also` has the further names of a cell.\n\
    Exit status 1: cells are left, because this machine does not have their engine, or a GPU failed during their run. The same \
    command drives them again."
)]
pub struct SweepArguments {
    #[command(subcommand)]
    pub command: Option<SweepCommand>,
    /// The plan, TOML.
    #[arg(value_name = "PLAN.toml", required_unless_present = "print_plan")]
    pub plan: Option<PathBuf>,
    /// Print a plan that has every key with its default and what it does.
    #[arg(long, conflicts_with = "plan")]
    pub print_plan: bool,
    /// Keep a file for each cell in this folder [default: inbye-sweep].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Only part I of N of the cells; the parts' sizes differ by at most one.
    #[arg(long, value_name = "I/N", allow_hyphen_values = true, value_parser = shard)]
    pub shard: Option<Shard>,
    /// Cells at a time [default: all cores].
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = whole::<usize>(1, 1024))]
    pub jobs: Option<usize>,
    /// Run nothing: print a line of JSON for each cell with its key and all its names; with --out prepare the folder, and print
    /// whether the cell is `done`.
    #[arg(long, conflicts_with_all = ["jobs", "cells"])]
    pub list: bool,
    /// Only the cell of this key; without --out print the content of its file. Repeatable.
    #[arg(long = "cell", value_name = "KEY")]
    pub cells: Vec<String>,
}

/// Commands for results.
#[derive(Debug, Subcommand)]
pub enum SweepCommand {
    /// Make one table and a report of the results in several folders.
    Merge(MergeArguments),
}

fn shard(text: &str) -> Result<Shard, ExperimentError> {
    text.parse()
}

/// Runs the cells of a plan, or lists them.
pub fn run(arguments: &SweepArguments) -> anyhow::Result<bool> {
    if let Some(SweepCommand::Merge(command)) = &arguments.command {
        return sweep_merge::run(command);
    }
    let Some(plan) = &arguments.plan else {
        let plan = Plan::documented();
        output::result(&json!({ "plan": plan }), [plan.trim_end()])?;
        return Ok(true);
    };
    let grid = read(plan)?;
    let cells = requested(&grid, arguments)?;
    let manifest = Manifest::of(&grid);
    let out = arguments.out.as_deref();
    if arguments.list {
        let folder = out.map(|out| ResultStore::open(out, &manifest)).transpose()?;
        return list(&grid, &cells, folder.as_ref());
    }
    let machine = machine::description();
    if out.is_none() && !arguments.cells.is_empty() {
        return print(&cells, &machine);
    }
    let out = out.unwrap_or(Path::new(FOLDER));
    let folder = ResultStore::open(out, &manifest)?;
    let workers = Workers {
        store: &folder,
        machine: &machine,
        title: "cells of the sweep",
        engines: SharedEngines::default(),
    };
    machine::interrupt_flag()?;
    let done = workers.run(&cells, arguments.jobs.unwrap_or_else(machine::cores))?;
    let (mut found, mut rows, mut left) = (0, Vec::new(), Vec::new());
    for (key, done) in &done {
        match done {
            Done::Found => found += 1,
            Done::Driven(row) => rows.push(&**row),
            Done::NoEngine(reason) => left.push(json!({ "key": key, "reason": reason })),
            Done::Busy | Done::Interrupted => {}
        }
    }
    let (count, driven) = (cells.len(), rows.len());
    let errors = rows.iter().filter(|row| row.outcome == RunOutcome::Error).count();
    let faults = faults(rows);
    let is_interrupted = machine::is_interrupted();
    let mut lines = vec![format!(
        "{}: {driven} driven, {found} found; {errors} did not start; in {}",
        counted(count, "cell"),
        out.display()
    )];
    lines.extend(fault_lines(&faults));
    if let Some(reason) = done.iter().find_map(|(_, done)| done.no_engine()) {
        lines.push(format!("{} left: {reason}", counted(left.len(), "cell")));
    }
    if is_interrupted {
        let open = count - driven - found - left.len();
        lines
            .push(format!("interrupted, {} open: the same command resumes", counted(open, "cell")));
    }
    let is_done = left.is_empty() && !is_interrupted;
    let object = json!({
        "cells": count, "found": found, "driven": driven, "errors": errors, "faults": faults, "left": left,
        "interrupted": is_interrupted,
        "out": out.to_string_lossy(),
    });
    output::result(&object, lines)?;
    Ok(is_done)
}

/// The grid of a plan's file.
pub fn read(file: &Path) -> anyhow::Result<Grid> {
    let place = || file.display().to_string();
    let text = read_text(file).with_context(place)?;
    // All keys have defaults, but a file without a character is no plan: a copy was cut off, say.
    ensure!(
        !text.trim().is_empty(),
        "{}: the file is empty: `inbye sweep --print-plan` prints a plan with all keys",
        place()
    );
    let plan = parse_toml(&text, &Plan::default(), Plan::check).with_context(place)?;
    let folder = file.parent().unwrap_or(Path::new(""));
    Grid::new(&plan, folder).map_err(|error| TomlError::in_text(&error, &text)).with_context(place)
}

/// The requested cells, each key once.
fn requested<'g>(grid: &'g Grid, arguments: &SweepArguments) -> anyhow::Result<Vec<&'g Cell>> {
    let all = grid.distinct();
    for key in &arguments.cells {
        ensure!(
            all.iter().any(|cell| cell.row.key == *key),
            ExperimentError::NoCell { key: key.clone() }
        );
    }
    let mut cells = all;
    cells.retain(|cell| arguments.cells.is_empty() || arguments.cells.contains(&cell.row.key));
    Ok(arguments.shard.map_or_else(|| cells.clone(), |shard| shard.of(&cells)))
}

/// Prints each cell with all its names, and whether it has its result in a folder.
fn list(grid: &Grid, cells: &[&Cell], folder: Option<&ResultStore>) -> anyhow::Result<bool> {
    let mut names: BTreeMap<&str, Vec<Value>> = BTreeMap::new();
    for cell in &grid.cells {
        names.entry(&cell.row.key).or_default().push(cell.row.names());
    }
    let mut lines = Vec::new();
    for cell in cells {
        let mut all = names.remove(cell.row.key.as_str()).unwrap_or_default().into_iter();
        let mut line = all.next().unwrap_or_default();
        let also: Vec<Value> = all.collect();
        if !also.is_empty() {
            line["also"] = json!(also);
        }
        if let Some(folder) = folder {
            line["done"] = json!(folder.row(&cell.row.key)?.is_some());
        }
        lines.push(line);
    }
    if output::is_json() {
        output::print_json(&json!({ "cells": lines }))?;
    } else {
        lines.iter().try_for_each(output::print_json)?;
    }
    Ok(true)
}

/// Runs cells and prints the content of their files; as JSON also their rows.
fn print(cells: &[&Cell], machine: &str) -> anyhow::Result<bool> {
    let mut files = Vec::new();
    let engines = SharedEngines::default();
    check_programs(cells.iter().copied())?;
    for cell in cells {
        let file = run_alone(cell, &engines, machine)?;
        if output::is_json() {
            files.push(json!({ "key": file.row.key, "row": file.row, "file": file.text() }));
        } else {
            output::line(file.text().trim_end());
        }
    }
    if output::is_json() {
        output::print_json(&json!({ "cells": files }))?;
    }
    Ok(true)
}
