//! `inbye bench compare`.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use clap::Args;
use inbye::bench::text_table;
use inbye::experiment::{RankedPlanner, RunRow, planner_name, rankings};
use inbye::report::{ComparisonReport, comparison_files};
use serde_json::json;

use super::arguments::whole;
use super::files::{ReportFolder, command_line};
use super::runs::RunArguments;
use super::{machine, output, run_page, sweep};

/// `inbye bench compare`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  inbye bench compare compare.toml --report comparison\n\n\
    The plan is one of `inbye sweep`. Each table [configs.NAME] is a planner, such as\n\n\
    \x20 [configs.inbye]\n\
    \x20 [configs.mine]\n\
    \x20 controller.command = [\"python3\", \"my_planner.py\"]\n\n\
    All planners drive the same worlds with the same seeds. They are ranked by their mean success weighted by completion time. \
    The difference to the best one is paired by world and seed, with an interval of 95 % confidence.\n\
    With --out the same command resumes where it was interrupted. Paths of worlds are relative to the plan, words of commands \
    to the working directory.\n\
    JSON fields: `ranked`, `rows`.")]
pub struct CompareArguments {
    /// The plan, TOML.
    #[arg(value_name = "PLAN.toml")]
    pub plan: PathBuf,
    #[command(flatten)]
    pub run: RunArguments,
    /// Write `index.html` with the ranking and every run, and both as CSV and JSON, into this folder.
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
    /// Drive the first N worlds and seeds again, and write a page that plays each run; the report links to it.
    #[arg(long, value_name = "N", requires = "report", default_value_t = 0, allow_negative_numbers = true, value_parser = whole::<usize>(0, 10_000))]
    pub play: usize,
}

/// Compares the planners of a plan.
pub fn run(arguments: &CompareArguments, json: bool) -> anyhow::Result<bool> {
    let grid = sweep::read(&arguments.plan)?.with_times();
    let folder = ReportFolder::create(arguments.report.as_deref())?;
    let rows = arguments.run.run(&grid, |_| {})?;
    let ranked = rankings(&rows);
    let lines = text_table(&ranked, RankedPlanner::SUMMARY).into_iter();
    let verdicts = ranked.iter().filter(|planner| planner.rank > 1);
    let verdicts =
        verdicts.map(|planner| format!("{}: {}", planner.planner, planner.verdict.text()));
    output::result(json, &json!({ "ranked": ranked, "rows": rows }), lines.chain(verdicts))?;
    let mut plays = BTreeMap::new();
    if let Some(report) = &arguments.report {
        let played = first_tasks(&rows, arguments.play);
        for cell in grid.distinct() {
            let row = &cell.row;
            if !machine::is_interrupted() && played.contains(&(row.world.clone(), row.seed)) {
                let file = file_name(row);
                run_page::write(cell, "--report", &report.join(&file))?;
                plays.insert(row.key.clone(), file);
            }
        }
    }
    folder.write(|| {
        comparison_files(&ComparisonReport {
            title: &grid.title,
            machine: &machine::description(),
            command: &command_line(),
            ranked: &ranked,
            rows: &rows,
            plays: &plays,
        })
    })?;
    Ok(true)
}

/// The first worlds and seeds of the rows.
fn first_tasks(rows: &[RunRow], count: usize) -> BTreeSet<(String, u64)> {
    let mut tasks = BTreeSet::new();
    for row in rows {
        if tasks.len() < count {
            tasks.insert((row.world.clone(), row.seed));
        }
    }
    tasks
}

/// The name of the page that plays a run.
fn file_name(row: &RunRow) -> String {
    let text = format!("{} {} {} {}", row.kind.name(), row.world, row.seed, planner_name(row));
    let plain = |letter: char| if letter.is_ascii_alphanumeric() { letter } else { '-' };
    format!("run-{}.html", text.chars().map(plain).collect::<String>())
}
