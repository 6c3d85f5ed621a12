//! `inbye bench compare`.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use clap::Args;
use inbye::bench::text_table;
use inbye::experiment::{Cell, Grid, RankedPlanner, RunRow, WorldKind, planner_names, rankings};
use inbye::report::{ComparisonReport, comparison_files};
use inbye::suggest::counted;
use serde_json::json;

use super::arguments::whole;
use super::files::{ReportFolder, all_written, command_line};
use super::runs::{self, RunArguments};
use super::{machine, output, run_page, sweep};

/// `inbye bench compare`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  inbye bench compare compare.toml --report comparison\n\n\
    The plan is one of `inbye sweep`. Each table [configs.NAME] is a planner, such as\n\n\
    \x20 [configs.inbye]\n\
    \x20 [configs.mine]\n\
    \x20 controller.command = [\"python3\", \"my_planner.py\"]\n\n\
    Weights, samplings and engines of the plan make further planners. All planners drive the same worlds with the same seeds. They \
    are ranked by their mean success weighted by completion time. The difference to the best one is paired by world and seed, with an \
    interval of 95 % confidence over the worlds; with fewer than 6 worlds there is none.\n\
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
pub fn run(arguments: &CompareArguments) -> anyhow::Result<bool> {
    let grid = sweep::read(&arguments.plan)?.with_times();
    let folder = ReportFolder::create(arguments.report.as_deref())?;
    let (rows, recorded) = arguments.run.run(&grid, |_| {})?;
    let missing = planners_without_runs(&grid, &rows);
    let ranked = if missing.is_empty() { rankings(&rows) } else { Vec::new() };
    let lines = ranked
        .chunk_by(|one, next| one.kind == next.kind)
        .flat_map(|ranking| ranking_text(ranking, ranking.len() < ranked.len()));
    let no_ranking = (!missing.is_empty())
        .then(|| format!("no ranking: no run yet of {}", Vec::from_iter(missing).join(", ")));
    let lines = lines.chain(no_ranking);
    output::result(&json!({ "ranked": ranked, "rows": rows }), lines)?;
    let plays = match &arguments.report {
        Some(report) => play(&grid.distinct(), &rows, arguments.play, report)?,
        None => BTreeMap::new(),
    };
    let reported = folder.write(|| {
        comparison_files(&ComparisonReport {
            title: &grid.title,
            note: runs::interruption(),
            machine: &machine::description(),
            command: &command_line(),
            ranked: &ranked,
            rows: &rows,
            plays: &plays,
            search: None,
        })
    });
    all_written([recorded, reported])?;
    Ok(true)
}

/// The planners of a grid that have no run yet, because the comparison was interrupted. A ranking without them would be wrong.
fn planners_without_runs(grid: &Grid, rows: &[RunRow]) -> BTreeSet<String> {
    let driven: BTreeSet<&str> = rows.iter().map(|row| &*row.key).collect();
    let planned: Vec<RunRow> = grid.cells.iter().map(|cell| cell.row.clone()).collect();
    let mut with_runs = BTreeMap::new();
    for (row, name) in planned.iter().zip(planner_names(&planned)) {
        *with_runs.entry(name).or_insert(false) |= driven.contains(&*row.key);
    }
    with_runs.into_iter().filter(|(_, has_runs)| !has_runs).map(|(name, _)| name).collect()
}

/// The ranking of the planners in worlds of one kind, with the name of the kind if there are several.
fn ranking_text(ranking: &[RankedPlanner], has_several: bool) -> Vec<String> {
    let kind = ranking.first().filter(|_| has_several).map(|planner| planner.kind);
    let mut lines: Vec<String> =
        kind.map(|kind| format!("Worlds: {}", kind.name())).into_iter().collect();
    lines.extend(text_table(ranking, RankedPlanner::SUMMARY));
    let verdicts = ranking.iter().filter(|planner| planner.rank > 1);
    lines
        .extend(verdicts.map(|planner| format!("{}: {}", planner.planner, planner.verdict.text())));
    lines.extend(ranking.iter().filter(|planner| planner.left_out > 0).map(|planner| {
        let RankedPlanner { planner, left_out, .. } = planner;
        let runs = counted(*left_out, "other run");
        format!("{planner}: not counted: {runs} in worlds or with seeds that another planner lacks")
    }));
    lines.extend(ranking.iter().filter_map(|planner| {
        planner.faults.as_ref().map(|faults| format!("{}: faults: {faults}", planner.planner))
    }));
    lines
}

/// Drives the first worlds and seeds again, and writes a page for each run in which the robot drove. Returns the files by the runs'
/// keys.
fn play(
    cells: &[&Cell],
    rows: &[RunRow],
    count: usize,
    report: &Path,
) -> anyhow::Result<BTreeMap<String, String>> {
    let played = first_tasks(rows, count);
    let names = planner_names(rows);
    let mut plays = BTreeMap::new();
    for (row, name) in rows.iter().zip(&names) {
        let is_played =
            played.contains(&task(row)) && row.ticks > 0 && !plays.contains_key(&row.key);
        if !is_played || machine::is_interrupted() {
            continue;
        }
        let Some(cell) = cells.iter().find(|cell| cell.row.key == row.key) else { continue };
        let file = file_name(row, name);
        let page = report.join(&file);
        if run_page::write(cell, Some(name), "--report", &page)?.result.is_some() {
            plays.insert(row.key.clone(), file);
        }
    }
    Ok(plays)
}

/// What each planner drives: a kind of world, a world and a seed.
type Task<'r> = (WorldKind, &'r str, u64);

fn task(row: &RunRow) -> Task<'_> {
    (row.kind, &row.world, row.seed)
}

/// The first tasks of the rows.
fn first_tasks(rows: &[RunRow], count: usize) -> BTreeSet<Task<'_>> {
    let mut tasks = BTreeSet::new();
    for row in rows {
        if tasks.len() < count {
            tasks.insert(task(row));
        }
    }
    tasks
}

/// Longest part of a file's name that describes the run: file systems permit 255 bytes.
const MAX_DESCRIPTION: usize = 100;
/// Hex digits of the key in a file's name. They tell runs apart whose descriptions are equal once letters are replaced.
const KEY_DIGITS: usize = 8;

/// The name of the page that plays a run.
fn file_name(row: &RunRow, planner: &str) -> String {
    let text = format!("{} {} {} {planner}", row.kind.name(), row.world, row.seed);
    let plain = |letter: char| if letter.is_ascii_alphanumeric() { letter } else { '-' };
    let description: String = text.chars().map(plain).take(MAX_DESCRIPTION).collect();
    let key: String = row.key.chars().take(KEY_DIGITS).collect();
    format!("run-{description}-{key}.html")
}

#[cfg(test)]
mod tests {
    use inbye::experiment::{Plan, WorldKind};
    use inbye::runtime::parse_toml;

    use super::*;

    #[test]
    fn planners_that_have_no_run_yet_are_named() {
        let plan = "seeds = [1, 2]\n[configs.one]\n[configs.two]\nlocal.sim_time_s = 2.0\n";
        let plan = parse_toml(plan, &Plan::default(), Plan::check).expect("a plan");
        let grid = Grid::new(&plan, Path::new("")).expect("a grid");
        let rows: Vec<RunRow> = grid.distinct().iter().map(|cell| cell.row.clone()).collect();
        assert_eq!(planners_without_runs(&grid, &rows), BTreeSet::new());
        let of_one: Vec<RunRow> =
            rows.iter().filter(|row| row.config.as_deref() == Some("one")).cloned().collect();
        assert_eq!(2 * of_one.len(), rows.len());
        assert_eq!(planners_without_runs(&grid, &of_one[..1]), ["two".to_owned()].into());
    }

    fn planner(kind: WorldKind) -> RankedPlanner {
        RankedPlanner { kind, rank: 1, planner: "mine".to_owned(), ..RankedPlanner::default() }
    }

    #[test]
    fn rankings_of_several_kinds_name_their_kind() {
        let one = ranking_text(&[planner(WorldKind::Barn)], true);
        assert_eq!(one.first().map(String::as_str), Some("Worlds: barn"));
        let alone = ranking_text(&[planner(WorldKind::Barn)], false);
        assert_eq!(alone, one[1..]);
    }
}
