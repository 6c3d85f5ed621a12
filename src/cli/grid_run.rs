//! Runs the cells of a built-in experiment.

use std::path::{Path, PathBuf};

use anyhow::bail;
use clap::Args;
use inbye::experiment::{Cell, CellFile, Grid, Manifest, RunRow, merge, run_in_order};

use super::arguments::whole;
use super::result_store::{self, ResultStore};
use super::sweep_workers::{Workers, run_alone};
use super::{engines, output};

/// Arguments that all built-in experiments have.
#[derive(Debug, Args)]
pub struct RunArguments {
    /// Runs at a time [default: all cores].
    #[arg(long, allow_negative_numbers = true, value_parser = whole::<usize>(1, 1024))]
    pub threads: Option<usize>,
    /// Keep the result of each run in this folder, and resume from it. `inbye sweep merge` reads it too.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Write a row for each run into this file, CSV or JSON by its ending.
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
}

impl RunArguments {
    /// Number of runs at a time.
    pub fn jobs(&self) -> usize {
        self.threads.unwrap_or_else(engines::cores)
    }

    /// Runs the cells that have no result yet; the rows of all, in the grid's order.
    pub fn run(&self, grid: &Grid) -> anyhow::Result<Vec<RunRow>> {
        run_grid(grid, self.out.as_deref(), self.jobs())
    }
}

/// Runs the cells of a grid that have no result in a folder, this many at a time; the rows of all, in the grid's order.
pub fn run_grid(grid: &Grid, out: Option<&Path>, jobs: usize) -> anyhow::Result<Vec<RunRow>> {
    let manifest = Manifest::of(grid);
    let machine = engines::machine();
    let Some(out) = out else {
        let run = |cell: &&Cell| run_alone(cell, &machine);
        return in_memory(grid, jobs, run);
    };
    let store = ResultStore::open(out, &manifest)?;
    let workers = Workers { store: &store, machine: &machine, title: &grid.title };
    let done = workers.run(&grid.distinct(), jobs)?;
    if let Some(reason) = done.iter().find_map(|(_, done)| done.no_engine()) {
        bail!("{reason}");
    }
    let (_, files) = result_store::read(out)?;
    Ok(merge(&manifest, files)?.rows)
}

/// Runs all cells of a grid without keeping results in files; the rows in the grid's order.
pub fn in_memory(
    grid: &Grid,
    jobs: usize,
    run: impl Fn(&&Cell) -> anyhow::Result<CellFile> + Sync,
) -> anyhow::Result<Vec<RunRow>> {
    let cells = grid.distinct();
    let bar = output::progress(cells.len() as u64, &grid.title);
    let files = run_in_order(&cells, jobs, run, || bar.inc(1))?;
    bar.finish_and_clear();
    let files = files.into_iter().map(|file| (PathBuf::new(), file));
    Ok(merge(&Manifest::of(grid), files.collect())?.rows)
}
