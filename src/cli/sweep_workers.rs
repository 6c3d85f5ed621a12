//! Workers that run cells: threads of this process, next to other processes.

use std::fs::{File, OpenOptions};
use std::io;

use anyhow::Context;
use inbye::experiment::{Cell, CellFile, RunOutcome, open_engine, run_cell, run_jobs};
use indicatif::ProgressBar;

use super::output;
use super::process::wall_clock;
use super::result_store::{NO_LOCKS, ResultStore};

/// The lock of the machine, in the system's folder for temporary files.
const MACHINE: &str = "inbye-sweep-machine.lock";

/// Runs cells and keeps their results.
pub struct Workers<'a> {
    /// Where results are kept.
    pub store: &'a ResultStore,
    /// The machine's name, for latencies.
    pub machine: &'a str,
    /// Title of the progress bar.
    pub title: &'a str,
}

/// What was done with a cell.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Done {
    /// It already had its result.
    Found,
    /// This process ran it.
    Driven {
        /// Whether the run did not start.
        is_error: bool,
    },
    /// Another process runs it.
    Busy,
    /// This machine does not have its engine.
    NoEngine(String),
}

impl Done {
    /// Why this machine could not run the cell.
    pub fn no_engine(&self) -> Option<&str> {
        match self {
            Self::NoEngine(reason) => Some(reason),
            _ => None,
        }
    }
}

impl Workers<'_> {
    /// Runs the cells that have no result, this many at a time, and then the latency cells, one at a time. Waits for cells
    /// that other processes run, and runs them here if that process ends without a result.
    pub fn run(&self, cells: &[&Cell], jobs: usize) -> anyhow::Result<Vec<(String, Done)>> {
        let bar = output::progress(cells.len() as u64, self.title);
        let (exclusive, shared): (Vec<&Cell>, Vec<&Cell>) =
            cells.iter().copied().partition(|cell| cell.row.latency);
        let mut done = self.pass(&shared, jobs, &bar)?;
        done.extend(self.pass(&exclusive, 1, &bar)?);
        bar.finish_and_clear();
        Ok(done)
    }

    /// Runs cells of one kind: first those that no process runs, then the rest.
    fn pass(
        &self,
        cells: &[&Cell],
        jobs: usize,
        bar: &ProgressBar,
    ) -> anyhow::Result<Vec<(String, Done)>> {
        let mut done = Vec::new();
        let mut open = cells.to_vec();
        for wait in [false, true] {
            let mut busy = Vec::new();
            let work = |cell: &&Cell| {
                let done = self.cell(cell, wait)?;
                Ok::<_, anyhow::Error>((cell.row.key.clone(), done))
            };
            run_jobs(&open, jobs, work, |(key, one)| {
                if one == Done::Busy {
                    busy.push(key);
                } else {
                    bar.inc(1);
                    done.push((key, one));
                }
                Ok(())
            })?;
            open.retain(|cell| busy.contains(&cell.row.key));
        }
        Ok(done)
    }

    fn cell(&self, cell: &Cell, wait: bool) -> anyhow::Result<Done> {
        let store = self.store;
        if store.has(&cell.row.key)? {
            return Ok(Done::Found);
        }
        let Some(claim) = store.claim(&cell.row.key, wait)? else {
            return Ok(Done::Busy);
        };
        // Another process may have finished it in between.
        if store.has(&cell.row.key)? {
            claim.done();
            return Ok(Done::Found);
        }
        let _machine = machine(cell.row.latency)?;
        store.log(&cell.row.key, "begun");
        let engine = match open_engine(cell) {
            Ok(engine) => engine,
            Err(error) => return Ok(Done::NoEngine(error.to_string())),
        };
        let file = run_cell(cell, engine, &mut wall_clock(), self.machine);
        store.keep(&file)?;
        claim.done();
        let is_error = file.row.outcome == RunOutcome::Error;
        Ok(Done::Driven { is_error })
    }
}

/// Runs a cell without keeping its result.
pub fn run_alone(cell: &Cell, machine_name: &str) -> anyhow::Result<CellFile> {
    let _machine = machine(cell.row.latency)?;
    let engine = open_engine(cell)?;
    Ok(run_cell(cell, engine, &mut wall_clock(), machine_name))
}

/// Locks the machine, exclusively or shared, and waits until it is free. The lock ends when the file is dropped.
fn machine(alone: bool) -> anyhow::Result<File> {
    let path = std::env::temp_dir().join(MACHINE);
    // Another user may own the file: opening it for reading is enough for a lock, and opening it for writing is refused.
    let opened = File::open(&path).or_else(|error| match error.kind() {
        io::ErrorKind::NotFound => {
            let mut options = OpenOptions::new();
            options.append(true).create(true).open(&path)
        }
        _ => Err(error),
    });
    let file = opened.with_context(|| path.display().to_string())?;
    let locked = if alone { file.lock() } else { file.lock_shared() };
    locked.context(NO_LOCKS).with_context(|| path.display().to_string())?;
    Ok(file)
}
