//! The common part of `inbye bench barn` and `inbye bench dynabarn`: numbered worlds, each driven with several seeds.

use std::path::PathBuf;

use clap::Args;
use inbye::experiment::{Grid, RunRow, Setup, World};
use inbye::local::CpuEngine;
use inbye::report::{BenchReport, bench_files};
use inbye::runtime::{Config, Observer};

use super::arguments::whole;
use super::grid_run::RunArguments;
use super::one_run::{Files, OneRun};
use super::output_file::Output;
use super::process::wall_clock;
use super::run_text::{run_name, run_text};
use super::{engines, output, output_file, report_file};

/// Worlds and seeds to drive, and where results go.
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
    #[command(flatten)]
    pub run: RunArguments,
    /// Settings that differ from the benchmark's, TOML.
    #[arg(long, value_name = "FILE.toml")]
    pub config: Option<PathBuf>,
    /// Write `index.html`, the chart by world as SVG and its rows as CSV and JSON into this folder.
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
    /// Make only this run, for --svg or --ticks.
    #[arg(long, value_name = "WORLD,SEED", conflicts_with_all = ["only", "seeds", "record", "report", "out"])]
    pub trace: Option<OneRun>,
    /// Draw the run of --trace into this file: obstacles, plans and the path driven.
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

    /// Drives all worlds with all seeds, and writes record and report; the rows, by world and seed.
    pub fn drive(
        &self,
        (title, intro): (&str, &str),
        worlds: &[World],
        config: &Config,
        report: for<'r> fn(&'r [RunRow]) -> BenchReport<'r>,
    ) -> anyhow::Result<Vec<RunRow>> {
        let record = Output::create("--record", self.run.record.as_deref(), &["csv", "json"])?;
        if let Some(folder) = &self.report {
            report_file::create_folder(folder)?;
        }
        let seeds: Vec<u64> = (0..self.seeds).collect();
        let setups = [Setup::unnamed(config.clone())];
        let rows = self.run.run(&Grid::of_worlds(title, worlds, &setups, &seeds)?)?;
        if let Some(record) = record {
            output_file::write_rows(record, &rows)?;
        }
        if let Some(folder) = &self.report {
            let files = bench_files(&BenchReport {
                intro,
                machine: &engines::machine(),
                command: &report_file::command_line(),
                ..report(&rows)
            });
            report_file::write_files(folder, &files)?;
        }
        Ok(rows)
    }

    /// Makes the run of `--trace`: draws it, writes its ticks, and prints it as text or JSON.
    pub fn one_run(
        &self,
        run: OneRun,
        title: &str,
        world: &World,
        config: &Config,
        json: bool,
    ) -> anyhow::Result<bool> {
        let files = Files::create(self.svg.as_deref(), self.ticks.as_deref())?;
        let mut observer = Observer { clock: &mut wall_clock(), on_tick: &mut |_| {} };
        let engine = Box::new(CpuEngine::single_threaded());
        let driven = world.drive(run.seed, config, engine, &mut observer)?;
        if let (Some(drawn), Some(result)) = (&driven.simulation, &driven.result) {
            let title = format!("{title} {}", run_name(&driven.row));
            files.write(&title, &drawn.simulation, result)?;
        }
        if json {
            output::json(&driven.row)?;
        } else {
            output::line(run_text(&driven.row));
        }
        Ok(true)
    }
}
