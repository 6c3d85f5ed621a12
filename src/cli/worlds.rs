//! What `inbye bench barn` and `inbye bench dynabarn` share: the worlds of a folder, each driven with some seeds.

use std::collections::BTreeSet;
use std::path::PathBuf;

use clap::Args;
use inbye::experiment::campaign::{Row, settings_digest};
use inbye::experiment::worlds::{RunKey, WorldTask, drive};
use inbye::report::{BenchReport, bench_files};
use inbye::runtime::Config;

use super::arguments::whole;
use super::campaign::Campaign;
use super::one_run::{Files, OneRun};
use super::process::wall_clock;
use super::{engines, output, report_file};

/// Which worlds are driven how often, and what is kept of it.
#[derive(Debug, Args)]
pub struct WorldsArguments {
    /// The folder of worlds.
    #[arg(long, value_name = "DIR")]
    pub worlds: PathBuf,
    /// Only these worlds, by their numbers [default: all].
    #[arg(long, value_name = "12,18", value_delimiter = ',', value_parser = whole::<u32>(0, u64::from(u32::MAX)))]
    pub only: Option<Vec<u32>>,
    /// Seeds of noise, from 0, with which each world is driven.
    #[arg(long, default_value_t = 1, allow_negative_numbers = true, value_parser = whole::<u64>(1, 1_000_000))]
    pub seeds: u64,
    /// Runs at a time [default: all cores].
    #[arg(long, allow_negative_numbers = true, value_parser = whole::<usize>(1, 1024))]
    pub threads: Option<usize>,
    /// Settings that shall differ from the benchmark's, TOML.
    #[arg(long, value_name = "FILE.toml")]
    pub config: Option<PathBuf>,
    /// Keep a row for each run in this file, and go on where it ends.
    #[arg(long, value_name = "FILE.csv")]
    pub record: Option<PathBuf>,
    /// Write `index.html` into this folder, and beside it the chart by world as SVG and its rows as CSV and JSON.
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
    /// Make this one run instead, to be looked at, with --svg or --ticks.
    #[arg(long, value_name = "WORLD,SEED", conflicts_with_all = ["only", "seeds", "record", "report"])]
    pub trace: Option<OneRun>,
    /// Draw the run of --trace into this file: what was there, what was planned, what was driven.
    #[arg(long, value_name = "FILE.svg", requires = "trace")]
    pub svg: Option<PathBuf>,
    /// Write every tick of the run of --trace as a line of JSON into this file.
    #[arg(long, value_name = "FILE", requires = "trace")]
    pub ticks: Option<PathBuf>,
}

impl WorldsArguments {
    /// Numbers of the worlds to read; none for all.
    pub fn numbers(&self) -> Option<Vec<u32>> {
        match self.trace {
            Some(run) => Some(vec![run.world]),
            None => self.only.clone(),
        }
    }

    /// The runs to make of these worlds.
    pub fn tasks<'w, W, T>(&self, worlds: &'w [W], task: impl Fn(&'w W, u64) -> T) -> Vec<T> {
        let seeds = match self.trace {
            Some(run) => run.seed..=run.seed,
            None => 0..=self.seeds - 1,
        };
        let task = &task;
        let of_world = |world| seeds.clone().map(move |seed| task(world, seed));
        worlds.iter().flat_map(of_world).collect()
    }

    /// Makes the runs that the record does not have; the rows of all, in the order of their keys.
    pub fn campaign<T: WorldTask>(
        &self,
        tasks: &[T],
        config: &Config,
    ) -> anyhow::Result<Vec<T::Row>> {
        let campaign = Campaign {
            what: "driving worlds",
            record: self.record.as_deref(),
            settings: &settings_digest(config),
            threads: self.threads.unwrap_or_else(engines::cores),
        };
        let work = |task: &T| Ok(drive(task, config, &mut wall_clock())?.0);
        let ledger = campaign.run(tasks, T::key, work)?;
        let asked: BTreeSet<RunKey> = tasks.iter().map(T::key).collect();
        let rows = ledger.rows().filter(|row| asked.contains(&row.key()));
        Ok(rows.cloned().collect())
    }

    /// Makes the folder of the report, so that a bad name is told before anything is driven.
    pub fn create_folder(&self) -> anyhow::Result<()> {
        self.report
            .as_deref()
            .map_or(Ok(()), report_file::create_folder)
    }

    /// Writes the report, where one is asked for: these rows, and where and how they came about.
    pub fn write_report(&self, rows: BenchReport) -> anyhow::Result<()> {
        let Some(folder) = &self.report else {
            return Ok(());
        };
        let files = bench_files(&BenchReport {
            machine: &engines::machine(),
            command: &report_file::command_line(),
            ..rows
        });
        report_file::write_files(folder, &files)
    }

    /// Makes one run: drawn, written tick by tick, and told in words or as JSON.
    pub fn one_run<T: WorldTask>(
        &self,
        benchmark: &str,
        task: &T,
        config: &Config,
        words: impl Fn(&T::Row) -> String,
        json: bool,
    ) -> anyhow::Result<bool> {
        let files = Files::create(self.svg.as_deref(), self.ticks.as_deref())?;
        let (row, result) = drive(task, config, &mut wall_clock())?;
        if let Some(result) = &result {
            let title = format!("{benchmark} {}", row.key());
            files.write(&title, &task.simulation()?, result)?;
        }
        if json {
            output::json(&row)?;
        } else {
            output::line(words(&row));
        }
        Ok(true)
    }
}

/// How a run ended, after which time and way, and why the navigator gave up, where it did.
pub fn in_one_line(
    key: RunKey,
    how: &str,
    time_s: f64,
    travelled_m: f64,
    fault: Option<&str>,
) -> String {
    let why = fault.map_or_else(String::new, |fault| format!(": {fault}"));
    format!("{key}: {how} after {time_s:.1} s and {travelled_m:.1} m{why}")
}
