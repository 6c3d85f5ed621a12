//! `inbye bench paper`.

use std::path::PathBuf;

use anyhow::Context;
use clap::Args;
use inbye::bench::paper::{
    MINE_SEARCHES, SEARCHES, Search, Site, TaskRuns, made_mine, measure, path_tables,
};
use inbye::experiment::paper_drives::{
    Course, DriveTable, PaperTable, TRAFFIC, drive_table, drive_worlds,
};
use inbye::experiment::{Grid, RunRow, Setup, TrafficKind, World, run_in_order};
use inbye::local::CpuEngine;
use inbye::report::{PaperReport, paper_files, paper_text};
use inbye::runtime::{Config, Observer, Trace};
use serde_json::json;

use super::arguments::whole;
use super::files::{ReportFolder, all_written};
use super::machine::{self, wall_clock};
use super::runs::{self, Recorded, RunArguments};
use super::{map_file, output};

/// Number of paths through the mine, as in Table 2.
const PATHS: usize = 5;
/// A path through the mine takes longer to plan than one through a roadway and is planned this many times less often.
const MINE_SHARE: usize = 5;

/// `inbye bench paper`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  inbye bench paper --repetitions 5 --runs 1 --report paper\n\n\
    Every variant searches the same free cells, for the default robot. Times are medians of searching, pruning and \
    smoothing, all variants in turn. Exit status 1: a path is closer to an obstacle than it must be, an exact search has one \
    that is not shortest, or a drive did not arrive. A drive among people who do not yield that ends because one of them walks \
    into the standing robot is a finding and no fault: the tables count it as a contact.\n\
    With --out the same command drives only what an interrupted one did not.")]
pub struct PaperArguments {
    /// Map of a mine for Table 2, any that `inbye plan` takes [default: a generated mine].
    #[arg(long, value_name = "FILE.yaml")]
    pub mine: Option<PathBuf>,
    /// Number of times that each path through a roadway is planned; those through the mine a fifth as often.
    #[arg(long, default_value_t = 101, allow_negative_numbers = true, value_parser = whole::<usize>(1, 100_000))]
    pub repetitions: usize,
    /// Drives through each of the three scenes without people, among people who yield, and among people who do not; 0 for
    /// paths alone.
    #[arg(long, default_value_t = 10, allow_negative_numbers = true, value_parser = whole::<usize>(0, 1000))]
    pub runs: usize,
    /// Seed of the generated mine, of the paths through a mine, and of the first drive; each further drive has the next.
    #[arg(long, default_value_t = 1, allow_negative_numbers = true, value_parser = whole::<u64>(0, u64::MAX))]
    pub seed: u64,
    /// Write `paper.html` with maps, charts and tables into this folder, and maps and charts as SVG, tables as CSV and JSON.
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
    #[command(flatten)]
    pub run: RunArguments,
}

/// Repeats the paper's tables. Returns false when a path or a drive has a fault.
pub fn run(arguments: &PaperArguments) -> anyhow::Result<bool> {
    let report = ReportFolder::create(arguments.report.as_deref())?;
    let config = Config::default();
    let sites = Site::roadways(&config);
    let mine = mine(arguments, &config)?;
    let mine_repetitions = arguments.repetitions.div_ceil(MINE_SHARE);
    let steps = sites.len() * arguments.repetitions + mine.tasks.len() * mine_repetitions;
    let bar = output::progress(steps as u64, "planning", "steps");
    let measured = |site: &Site, searches: &[Search], repetitions| {
        measure(site, searches, repetitions, &mut wall_clock(), || bar.inc(1))
    };
    let mut roadways: Vec<TaskRuns> = Vec::new();
    for site in &sites {
        roadways.extend(measured(site, &SEARCHES, arguments.repetitions)?);
    }
    let mine_paths = measured(&mine, &MINE_SEARCHES, mine_repetitions)?;
    bar.finish_and_clear();
    let courses = Course::all(&sites, &config)?;
    let worlds = drive_worlds(&courses);
    let (rows, recorded) = drives(arguments, &worlds, &config)?;
    let (paths, steps) = path_tables(&roadways, &mine_paths, &mine.title);
    let tables: Vec<PaperTable> = (paths.into_iter().map(PaperTable::Paths))
        .chain(steps.into_iter().map(PaperTable::Ablation))
        .chain(drive_tables(&rows).map(PaperTable::Drives))
        .collect();
    let roadways: Vec<(&Site, &TaskRuns)> = sites.iter().zip(&roadways).collect();
    let mut faults: Vec<String> =
        roadways.iter().flat_map(|(site, task)| task.faults(site)).collect();
    faults.extend(mine_paths.iter().flat_map(|task| task.faults(&mine)));
    for table in &tables {
        if let PaperTable::Drives(table) = table {
            faults.extend(table.faults());
        }
    }
    let lines = tables.iter().flat_map(paper_text).chain(faults.clone());
    output::result(&json!({ "tables": tables, "faults": faults }), lines)?;
    let mut written = vec![recorded];
    if arguments.report.is_some() {
        let traces = traces(arguments, &worlds, &config)?;
        written.push(report.write(|| {
            paper_files(&PaperReport {
                note: runs::interruption(),
                machine: &machine::description(),
                command: &command(arguments),
                roadways,
                mine: (&mine, &mine_paths),
                courses: &courses,
                traces: &traces,
                footprint: &config.robot.footprint,
                tables: &tables,
                faults: &faults,
            })
        }));
    }
    all_written(written)?;
    Ok(faults.is_empty())
}

/// A table of the drives in each kind of traffic. An interrupted experiment has fewer of some.
fn drive_tables(rows: &[RunRow]) -> impl Iterator<Item = DriveTable> {
    TRAFFIC.into_iter().filter_map(|traffic| {
        let rows: Vec<RunRow> =
            rows.iter().filter(|row| row.traffic == Some(traffic)).cloned().collect();
        (!rows.is_empty()).then(|| drive_table(traffic, rows))
    })
}

/// All drives; none with `--runs 0`.
fn drives(
    arguments: &PaperArguments,
    worlds: &[World],
    config: &Config,
) -> anyhow::Result<Recorded> {
    let seeds: Vec<u64> =
        (0..arguments.runs).map(|run| arguments.seed.wrapping_add(run as u64)).collect();
    let setups = [Setup::unnamed(config.clone())];
    arguments.run.run(&Grid::of_worlds("driving", worlds, &setups, &seeds)?, |_| {})
}

/// The first drive in each world once more, tick by tick, to draw it; none with `--runs 0`.
fn traces(
    arguments: &PaperArguments,
    worlds: &[World],
    config: &Config,
) -> anyhow::Result<Vec<(TrafficKind, Trace)>> {
    let worlds = if arguments.runs == 0 { &[] } else { worlds };
    let drive = |world: &World| {
        let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut |_| {} };
        let engine = Box::new(CpuEngine::single_threaded());
        let run = world.drive(arguments.seed, config, engine, &mut observer)?;
        let trace = run.result.map(|result| result.trace).unwrap_or_default();
        Ok((run.row.traffic.unwrap_or(TrafficKind::None), trace))
    };
    run_in_order(worlds, arguments.run.jobs(), drive, || ())
}

fn mine(arguments: &PaperArguments, config: &Config) -> anyhow::Result<Site> {
    let seed = arguments.seed;
    let Some(file) = &arguments.mine else {
        let title = format!("a generated mine, seed {seed}");
        return Ok(Site::mine(&title, made_mine(seed), PATHS, seed, config)?);
    };
    let map = map_file::load(file, 1.0)?;
    let name = file.file_stem().unwrap_or_default().to_string_lossy();
    Site::mine(&name, map, PATHS, seed, config).with_context(|| file.display().to_string())
}

/// The command that repeats the run.
fn command(arguments: &PaperArguments) -> String {
    let PaperArguments { mine, repetitions, runs, seed, .. } = arguments;
    let mine = mine.as_ref().map_or_else(String::new, |file| format!(" --mine {}", file.display()));
    format!(
        "inbye bench paper{mine} --repetitions {repetitions} --runs {runs} --seed {seed} --report DIR"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_have_the_drives_of_their_traffic_after_an_interruption() {
        let row = |traffic, seed| RunRow { traffic: Some(traffic), seed, ..RunRow::default() };
        let rows = [row(TRAFFIC[0], 1), row(TRAFFIC[0], 2), row(TRAFFIC[0], 3), row(TRAFFIC[2], 1)];
        let tables: Vec<_> =
            drive_tables(&rows).map(|table| (table.traffic, table.rows.len())).collect();
        assert_eq!(tables, [(TRAFFIC[0], 3), (TRAFFIC[2], 1)]);
    }
}
