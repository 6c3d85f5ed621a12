//! Who runs the cells of a sweep: threads here, and other processes beside us.

use std::fs::{File, OpenOptions};
use std::io;

use anyhow::Context;
use inbye::experiment::campaign::run_cells;
use inbye::experiment::sweep::{Cell, CellFile, CellResult, open_engine, run_cell};
use indicatif::ProgressBar;

use super::output;
use super::process::wall_clock;
use super::sweep_folder::{Folder, LOCKS};

/// The file that says who has the machine, in the system's folder for temporary files.
const MACHINE: &str = "inbye-sweep-machine.lock";

/// Runs cells.
pub struct Crew<'a> {
    /// Where results are kept.
    pub folder: &'a Folder,
    /// The machine's name, for latencies.
    pub machine: &'a str,
}

/// What became of a cell.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Done {
    /// It had its result.
    Found,
    /// We ran it.
    Driven {
        /// Whether its result is that it could not be begun.
        is_error: bool,
    },
    /// Somebody else is at it.
    Busy,
    /// This machine does not have its engine.
    NoEngine(String),
}

impl Crew<'_> {
    /// Runs the cells that have no result, so many at a time; those that need the machine for themselves after all others, one
    /// at a time. Cells that other processes are at are waited for, and run here if their process ends without a result.
    pub fn run(&self, cells: &[&Cell], jobs: usize) -> anyhow::Result<Vec<(String, Done)>> {
        let bar = output::progress(cells.len() as u64, "cells of the sweep");
        let (exclusive, shared): (Vec<&Cell>, Vec<&Cell>) =
            cells.iter().copied().partition(|cell| cell.label.latency);
        let mut done = self.pass(&shared, jobs, &bar)?;
        done.extend(self.pass(&exclusive, 1, &bar)?);
        bar.finish_and_clear();
        Ok(done)
    }

    /// Runs cells of one kind: first those that nobody is at, then what is left.
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
                Ok::<_, anyhow::Error>((cell.key.clone(), done))
            };
            run_cells(&open, jobs, work, |(key, one)| {
                if one == Done::Busy {
                    busy.push(key);
                } else {
                    bar.inc(1);
                    done.push((key, one));
                }
                Ok(())
            })?;
            open.retain(|cell| busy.contains(&cell.key));
        }
        Ok(done)
    }

    fn cell(&self, cell: &Cell, wait: bool) -> anyhow::Result<Done> {
        let folder = self.folder;
        if folder.has(&cell.key)? {
            return Ok(Done::Found);
        }
        let Some(claim) = folder.claim(&cell.key, wait)? else {
            return Ok(Done::Busy);
        };
        // Whoever had it may have finished it in between.
        if folder.has(&cell.key)? {
            claim.done();
            return Ok(Done::Found);
        }
        let _machine = machine(cell.label.latency)?;
        folder.tell(&cell.key, "begun");
        let engine = match open_engine(cell) {
            Ok(engine) => engine,
            Err(error) => return Ok(Done::NoEngine(error.to_string())),
        };
        let file = run_cell(cell, engine, &mut wall_clock(), self.machine);
        folder.keep(&file)?;
        claim.done();
        let is_error = file.outcome.result == CellResult::Error;
        Ok(Done::Driven { is_error })
    }
}

/// Runs a cell, and keeps nothing.
pub fn run_alone(cell: &Cell, machine_name: &str) -> anyhow::Result<CellFile> {
    let _machine = machine(cell.label.latency)?;
    let engine = open_engine(cell)?;
    Ok(run_cell(cell, engine, &mut wall_clock(), machine_name))
}

/// Takes the machine, alone or with others; waits until it is free. It is let go when the file is dropped, or its process ends.
fn machine(alone: bool) -> anyhow::Result<File> {
    let path = std::env::temp_dir().join(MACHINE);
    // Another user may have made it: reading is enough to lock it, and asking to make it anew is refused.
    let opened = File::open(&path).or_else(|error| match error.kind() {
        io::ErrorKind::NotFound => {
            let mut options = OpenOptions::new();
            options.append(true).create(true).open(&path)
        }
        _ => Err(error),
    });
    let file = opened.with_context(|| path.display().to_string())?;
    let locked = if alone {
        file.lock()
    } else {
        file.lock_shared()
    };
    locked
        .context(LOCKS)
        .with_context(|| path.display().to_string())?;
    Ok(file)
}
