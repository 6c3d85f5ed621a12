//! Runs the cells of experiments on threads of this process, next to other processes, and prints runs and their groups.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use anyhow::bail;
use clap::Args;
use inbye::bench::text_table;
use inbye::experiment::{
    Cell, CellFile, ContactCause, Grid, Group, Manifest, RunOutcome, RunRow, WorldKind,
    check_programs, merge, open_engine, run_cell, run_in_order, run_jobs,
};
use inbye::local::SharedEngines;
use inbye::suggest::counted;
use indicatif::ProgressBar;

use super::arguments::whole;
use super::files::Output;
use super::latency_lock;
use super::machine::{self, interrupt_flag, is_interrupted, wall_clock};
use super::output;
use super::result_store::{self, IfBusy, ResultStore};

/// Arguments that all built-in experiments have.
#[derive(Debug, Args)]
pub struct RunArguments {
    /// Runs at a time [default: all cores].
    #[arg(long, allow_negative_numbers = true, value_parser = whole::<usize>(1, 1024))]
    pub threads: Option<usize>,
    /// Keep the result of each run in this folder, and resume from it. `inbye sweep merge` reads it too.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Write a row for each run into this file, CSV or JSON by its extension.
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
}

impl RunArguments {
    /// Number of runs at a time.
    pub fn jobs(&self) -> usize {
        self.threads.unwrap_or_else(machine::cores)
    }

    /// Runs the cells that have no result yet, and writes the record unless it is interrupted; the rows of all, in the grid's order
    /// or as `sort` leaves them, and whether the record was written. The caller returns that error at its end: a full disk for the
    /// record must not prevent the result and the report.
    pub fn run(&self, grid: &Grid, sort: fn(&mut [RunRow])) -> anyhow::Result<Recorded> {
        let record = Output::of_rows::<RunRow>("--record", self.record.as_deref())?;
        interrupt_flag()?;
        let mut rows = run_grid(grid, self.out.as_deref(), self.jobs())?;
        sort(&mut rows);
        let written = if is_interrupted() {
            let kept = self.out.as_ref().map_or_else(
                || "they are not kept: with --out DIR the same command could resume".to_owned(),
                |out| format!("they are kept in {}: the same command resumes", out.display()),
            );
            output::warn(format!(
                "interrupted after {} of {}; {kept}",
                rows.len(),
                counted(grid.distinct().len(), "run")
            ));
            Ok(())
        } else {
            record.write_rows(&rows)
        };
        Ok((rows, written))
    }
}

/// The rows of runs, and whether their record was written.
pub type Recorded = (Vec<RunRow>, anyhow::Result<()>);

/// What a page of an experiment says if Ctrl-C interrupted it; empty otherwise.
pub fn interruption() -> &'static str {
    if is_interrupted() {
        "The experiment was interrupted: runs may be missing, and all figures are those of the runs that were made."
    } else {
        ""
    }
}

/// Runs the cells of a grid that have no result in a folder, this many at a time; the rows of all, in the grid's order.
pub fn run_grid(grid: &Grid, out: Option<&Path>, jobs: usize) -> anyhow::Result<Vec<RunRow>> {
    let machine = machine::description();
    let Some(out) = out else {
        check_programs(&grid.cells)?;
        let engines = SharedEngines::default();
        return in_memory(grid, jobs, |cell| run_alone(cell, &engines, &machine));
    };
    let manifest = Manifest::of(grid);
    let store = ResultStore::open(out, &manifest)?;
    let workers = Workers {
        store: &store,
        machine: &machine,
        title: &grid.title,
        engines: SharedEngines::default(),
    };
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
    let bar = output::progress(cells.len() as u64, &grid.title, "runs");
    let run = |cell: &&Cell| {
        let file = (!is_interrupted()).then(|| run(cell)).transpose()?;
        anyhow::Ok(file.filter(|file| !is_cut(cell, &file.row)))
    };
    let files = run_in_order(&cells, jobs, run, || bar.inc(1))?;
    bar.finish_and_clear();
    let files = files.into_iter().flatten().map(|file| (PathBuf::new(), file));
    Ok(merge(&Manifest::of(grid), files.collect())?.rows)
}

/// Whether Ctrl-C may have ended a program during the run of a cell, and so the run.
fn is_cut(cell: &Cell, row: &RunRow) -> bool {
    let is_sound = matches!(row.outcome, RunOutcome::Reached | RunOutcome::Contact);
    is_interrupted() && cell.has_programs() && !is_sound
}

/// Runs cells and keeps their results.
pub struct Workers<'a> {
    /// The folder of results.
    pub store: &'a ResultStore,
    /// The machine's name, for latencies.
    pub machine: &'a str,
    /// Title of the progress bar.
    pub title: &'a str,
    /// The engines of cells that run side by side.
    pub engines: SharedEngines,
}

/// Keys of the cells whose earlier runs a program failed.
type Failed<'a> = BTreeSet<&'a str>;

/// What was done with a cell.
#[derive(Clone, Debug)]
pub enum Done {
    /// It already had its result.
    Found,
    /// This process ran it.
    Driven(Box<RunRow>),
    /// Another process runs it.
    Busy,
    /// Ctrl-C came before it began, or while its programs ran.
    Interrupted,
    /// This machine does not have its engine, or its GPU failed during the run. The cell has no result.
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
    /// Checks the programs of the cells that have no final result, then runs these cells, this many at a time, and then the latency
    /// cells, one at a time. Waits for cells that other processes run, and runs them here if that process ends without a result.
    pub fn run(&self, cells: &[&Cell], jobs: usize) -> anyhow::Result<Vec<(String, Done)>> {
        let (mut open, mut failed) = (Vec::new(), Failed::new());
        for &cell in cells.iter().filter(|cell| cell.has_programs()) {
            match self.store.row(&cell.row.key)? {
                Some(row) if !cell.is_failed_by_machine(&row) => continue,
                Some(_) => drop(failed.insert(&cell.row.key)),
                None => {}
            }
            open.push(cell);
        }
        if !failed.is_empty() {
            output::note(format!(
                "{} earlier runs in which a program did not start or did not answer are driven again",
                failed.len()
            ));
        }
        check_programs(open)?;
        let bar = output::progress(cells.len() as u64, self.title, "runs");
        let (exclusive, shared): (Vec<&Cell>, Vec<&Cell>) =
            cells.iter().copied().partition(|cell| cell.row.latency);
        let mut done = self.pass(shared, &failed, jobs, &bar)?;
        done.extend(self.pass(exclusive, &failed, 1, &bar)?);
        bar.finish_and_clear();
        Ok(done)
    }

    /// Runs cells of one kind: first those that no process runs, then the rest.
    fn pass(
        &self,
        mut open: Vec<&Cell>,
        failed: &Failed<'_>,
        jobs: usize,
        bar: &ProgressBar,
    ) -> anyhow::Result<Vec<(String, Done)>> {
        let mut done = Vec::new();
        for if_busy in [IfBusy::Skip, IfBusy::Wait] {
            let mut busy = Vec::new();
            let work = |cell: &&Cell| {
                anyhow::Ok((cell.row.key.clone(), self.cell(cell, failed, if_busy)?))
            };
            run_jobs(&open, jobs, work, |(key, one)| {
                if matches!(one, Done::Busy) {
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

    /// Whether a cell has a result that need not be driven again. A failed one stays until a better one replaces it: another process
    /// may have written the better one already.
    fn has_result(&self, cell: &Cell, failed: &Failed<'_>) -> anyhow::Result<bool> {
        let row = self.store.row(&cell.row.key)?;
        Ok(row.is_some_and(|row| {
            !failed.contains(&*cell.row.key) || !cell.is_failed_by_machine(&row)
        }))
    }

    fn cell(&self, cell: &Cell, failed: &Failed<'_>, if_busy: IfBusy) -> anyhow::Result<Done> {
        let store = self.store;
        if is_interrupted() {
            return Ok(Done::Interrupted);
        }
        if self.has_result(cell, failed)? {
            return Ok(Done::Found);
        }
        let Some(claim) = store.claim(&cell.row.key, if_busy)? else {
            return Ok(Done::Busy);
        };
        // Another process may have finished it in between.
        if self.has_result(cell, failed)? {
            claim.done();
            return Ok(Done::Found);
        }
        let _lock = latency_lock::of(cell)?;
        store.log(&cell.row.key, "begun");
        let engine = match open_engine(cell, &self.engines) {
            Ok(engine) => engine,
            Err(error) => return Ok(Done::NoEngine(error.to_string())),
        };
        let file = match run_cell(cell, engine, &mut wall_clock(), self.machine) {
            Ok(file) => file,
            Err(error) => {
                store.log(&cell.row.key, "failed");
                return Ok(Done::NoEngine(error.to_string()));
            }
        };
        if is_cut(cell, &file.row) {
            return Ok(Done::Interrupted);
        }
        store.keep(&file)?;
        claim.done();
        Ok(Done::Driven(Box::new(file.row)))
    }
}

/// Runs a cell without keeping its result.
pub fn run_alone(
    cell: &Cell,
    engines: &SharedEngines,
    machine_name: &str,
) -> anyhow::Result<CellFile> {
    let _lock = latency_lock::of(cell)?;
    Ok(run_cell(cell, open_engine(cell, engines)?, &mut wall_clock(), machine_name)?)
}

/// A line for each fault with which navigators gave up, with its number of runs.
pub fn fault_lines(faults: &BTreeMap<&str, usize>) -> impl Iterator<Item = String> {
    faults.iter().map(|(name, count)| format!("gave up, {name}: {count}"))
}

/// A table of groups.
pub fn group_table(groups: &[Group]) -> Vec<String> {
    let has_score = groups.iter().any(|group| group.mean_score.is_some());
    text_table(
        groups,
        &format!(
            "{}{}",
            Group::ENDS,
            if has_score { " mean_score mean_time_over_optimal" } else { "" }
        ),
    )
}

/// One line for each run that did not reach its goal.
pub fn unreached<'a>(rows: impl IntoIterator<Item = &'a RunRow>) -> impl Iterator<Item = String> {
    let unreached = rows.into_iter().filter(|row| !row.reached());
    unreached.map(|row| format!("  {}", run_text(row)))
}

/// A run in one line: how it ended, when, and why the goal was not reached.
pub fn run_text(row: &RunRow) -> String {
    let how = match (row.outcome, row.contact_cause) {
        (RunOutcome::Contact, Some(ContactCause::Avoidable)) => "was hit, avoidably,",
        (RunOutcome::Contact, Some(ContactCause::Other)) => "was hit",
        (outcome, _) => outcome.text(),
    };
    let path = row.path_m.map_or_else(String::new, |path_m| format!(" of {path_m:.1} m"));
    let why = row.reason.as_ref().map_or_else(String::new, |reason| format!(": {reason}"));
    let (name, time_s, travelled_m) = (run_name(row), row.time_s, row.travelled_m);
    format!("{name}: {how} after {time_s:.1} s and {travelled_m:.1} m{path}{why}")
}

/// World and seed of a run.
pub fn run_name(row: &RunRow) -> String {
    let is_numbered = matches!(row.kind, WorldKind::Barn | WorldKind::DynaBarn);
    let world = if is_numbered { "world " } else { "" };
    format!("{world}{}, seed {}", row.world, row.seed)
}
