//! `inbye tune`.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf, absolute};
use std::process::Stdio;
use std::sync::Arc;
use std::{fs, io};

use anyhow::{Context, bail, ensure};
use clap::Args;
use inbye::experiment::{
    Changes, Grid, Plan, Point, RankedPlanner, RunRow, TuningPlan, WorldSettings, fault_text,
    rankings,
};
use inbye::external::{ProgramSettings, run_in_group};
use inbye::input_file::read_text;
use inbye::report::{ComparisonReport, SearchResult, comparison_files};
use inbye::runtime::{TomlError, parse_toml};
use serde_json::{Value, json};

use super::files::{Output, ReportFolder, all_written, command_line};
use super::own_file::TUNED_SETTINGS;
use super::own_programs::{Words, words};
use super::runs::{Recorded, RunArguments};
use super::whole_file::write_whole;
use super::{machine, output};

/// Name of the settings without changes.
const DEFAULT: &str = "default";
/// Name of the best candidate in the judgement on other worlds.
const TUNED: &str = "tuned";

/// Names of the runs that choose the best candidate, and of those that judge it.
const SEARCH: &str = "search";
const OTHER_WORLDS: &str = "other worlds";

/// Folder of the results of the judgement, below that of --out.
const JUDGE: &str = "judge";
/// Name of the sweep that a runner gets.
const PLAN: &str = "plan.toml";

/// The search has too many runs for rows of its own.
const RECORD_HELP: &str =
    "Write a row for each run of the judgement into this file, CSV or JSON by its extension";

/// `inbye tune`.
#[derive(Debug, Args)]
#[command(
    mut_arg("record", |record| record.help(RECORD_HELP)),
    after_help = "Example:\n  inbye tune --print-plan\n  inbye tune tune.toml --out tuning --save tuned.toml\n\n\
    The plan names settings with their ranges, worlds for the search, and other worlds that judge the best candidate. The search \
    starts from the worlds' own settings with the changes of [config], such as those of your own robot. Each round \
    drives its candidates through all worlds of the search; the next round draws candidates near the best three. Candidates are \
    ranked by the mean success weighted by completion time. The result gives the gain over the unchanged settings on both sets of \
    worlds. A gain on the first set alone is overfitting.\n\
    With --out the same command resumes where it was interrupted, and processes on several machines that share the folder divide \
    the runs between them.\n\
    JSON fields: `changes`, `train` and `judge` (`default`, `tuned`), `faults` (`train`, `judge`), `ranked`, `candidates`, \
    `interrupted`; what an interrupted command does not know is null.\n\
    Exit status 1: no run of the search or of the judgement reached its goal."
)]
pub struct TuneArguments {
    /// The plan, TOML.
    #[arg(value_name = "PLAN.toml", required_unless_present = "print_plan")]
    pub plan: Option<PathBuf>,
    /// Print a plan that has every key with its default and what it does.
    #[arg(long, conflicts_with = "plan")]
    pub print_plan: bool,
    #[command(flatten)]
    pub run: RunArguments,
    #[arg(
        long,
        value_name = "COMMAND",
        value_parser = words,
        requires = "out",
        help = "Program that runs the cells of each round elsewhere, such as \"python3 examples/sweep_ray.py\": it gets a plan of \
            `inbye sweep`, and --out with a folder below that of this command. inbye runs the cells that it leaves open"
    )]
    pub runner: Option<Words>,
    /// Write the best settings into this file, for --config.
    #[arg(long, value_name = "FILE.toml")]
    pub save: Option<PathBuf>,
    /// Write the page of the judgement into this folder: `index.html`, with the rows as CSV and JSON.
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
}

/// A candidate with its success in the search.
struct Candidate {
    point: Option<Point>,
    changes: String,
    success: f64,
}

/// The rounds of a search that were not interrupted.
struct Search {
    /// The best first.
    candidates: Vec<Candidate>,
    rows: Vec<RunRow>,
}

/// The runs of the settings without changes and of the best candidate on other worlds.
struct Judgement {
    rows: Vec<RunRow>,
    ranked: Vec<RankedPlanner>,
}

/// Searches settings and judges the best ones. False if no run of the search, or none of the judgement, reached its goal.
pub fn run(arguments: &TuneArguments) -> anyhow::Result<bool> {
    let Some(file) = &arguments.plan else {
        let plan = TuningPlan::documented();
        output::result(&json!({ "plan": plan }), [plan.trim_end()])?;
        return Ok(true);
    };
    let (plan, settings) = read(file)?;
    let save = Output::create("--save", arguments.save.as_deref(), &["toml"])?;
    let report = ReportFolder::create(arguments.report.as_deref())?;
    let search = search(arguments, (&plan, file), &settings)?;
    let best = search.candidates.first().filter(|_| !machine::is_interrupted());
    let Some(best) = best else {
        print(&search, None)?;
        return Ok(false);
    };
    let configs = BTreeMap::from([
        (DEFAULT.to_owned(), changes("")?),
        (TUNED.to_owned(), changes(&best.changes)?),
    ]);
    let sweep = plan.plan(&plan.judge, configs);
    let (rows, recorded) = runs(arguments, (&sweep, file), JUDGE)?;
    if machine::is_interrupted() {
        print(&search, None)?;
        recorded?;
        return Ok(false);
    }
    let judgement = Judgement { ranked: rankings(&rows), rows };
    print(&search, Some(&judgement))?;
    let settings = plan.settings_with(&best.changes).map_err(anyhow::Error::msg)?;
    let saved = save.write(|| {
        format!("{TUNED_SETTINGS}; all other settings have their defaults.\n\n{settings}")
    });
    let reported = report.write(|| {
        comparison_files(&ComparisonReport {
            title: &plan.title,
            note: "",
            machine: &machine::description(),
            command: &command_line(),
            ranked: &judgement.ranked,
            rows: &judgement.rows,
            plays: &BTreeMap::new(),
            search: Some(SearchResult {
                changes: &best.changes,
                train: search.successes(),
                judge: judgement.successes(),
            }),
        })
    });
    all_written([recorded, saved, reported])?;
    Ok([&search.rows, &judgement.rows].into_iter().all(|rows| has_arrived(rows)))
}

/// The plan of a file, with all its values and worlds checked, and the settings of the worlds.
fn read(file: &Path) -> anyhow::Result<(TuningPlan, Vec<Arc<WorldSettings>>)> {
    let place = || file.display().to_string();
    let text = read_text(file).with_context(place)?;
    let plan = parse_toml(&text, &TuningPlan::default(), TuningPlan::check).with_context(place)?;
    let settings = plan
        .settings_of_worlds(file.parent().unwrap_or(Path::new("")))
        .and_then(|settings| plan.check_values(&settings).map(|()| settings))
        .map_err(|error| TomlError::in_text(&error, &text))
        .with_context(place)?;
    Ok((plan, settings))
}

/// Drives the rounds of a search, up to an interruption.
fn search(
    arguments: &TuneArguments,
    (plan, file): (&TuningPlan, &Path),
    settings: &[Arc<WorldSettings>],
) -> anyhow::Result<Search> {
    let (mut all, mut searched): (Vec<Candidate>, Vec<RunRow>) = Default::default();
    let first_error = RefCell::new(None);
    // Whether the settings are valid together, as changes of those of each world.
    let error_of = |changes: &str| settings.iter().find_map(|one| one.with_changes(changes).err());
    let is_usable = |changes: &str| match error_of(changes) {
        None => true,
        Some(error) => {
            first_error.borrow_mut().get_or_insert(error);
            false
        }
    };
    for round in 0..plan.rounds {
        let points: Vec<Point> =
            all.iter().filter_map(|candidate| candidate.point.clone()).collect();
        let drawn = plan.round(round, &points, is_usable);
        let mut new: Vec<Candidate> = drawn
            .into_iter()
            .map(|point| Candidate {
                changes: plan.changes(&point),
                point: Some(point),
                success: 0.0,
            })
            .collect();
        if new.is_empty() {
            let why = first_error.take().map_or_else(String::new, |error| error.to_string());
            bail!(
                "{}: no settings of [space] are valid; the first drawn ones: {why}",
                file.display()
            );
        }
        if round == 0 {
            new.insert(0, Candidate { point: None, changes: String::new(), success: 0.0 });
        }
        let names = (0..new.len()).map(|index| format!("{round}-{index:04}"));
        let configs = names.clone().zip(&new).map(|(name, it)| Ok((name, changes(&it.changes)?)));
        let configs: BTreeMap<String, Changes> = configs.collect::<anyhow::Result<_>>()?;
        let sweep = plan.plan(&plan.train, configs);
        let (rows, recorded) = runs(arguments, (&sweep, file), &format!("round-{round}"))?;
        recorded?;
        if machine::is_interrupted() {
            break;
        }
        let success = |name: &str| success(of(&rows, name));
        names.zip(&mut new).for_each(|(name, candidate)| candidate.success = success(&name));
        searched.extend(rows);
        all.extend(new);
        // A stable order: of equal ones the earlier counts.
        all.sort_by(|one, other| other.success.total_cmp(&one.success));
        output::detail(format!("round {}: best {:.3}", round + 1, all[0].success));
    }
    Ok(Search { candidates: all, rows: searched })
}

impl Search {
    /// The successes of the settings without changes and of the best candidate.
    fn successes(&self) -> [f64; 2] {
        let without = self.candidates.iter().find(|candidate| candidate.point.is_none());
        [without, self.candidates.first()].map(|one| one.map_or(0.0, |one| one.success))
    }
}

impl Judgement {
    /// The successes of the settings without changes and of the best candidate.
    fn successes(&self) -> [f64; 2] {
        [DEFAULT, TUNED].map(|name| success(of(&self.rows, name)))
    }
}

/// Prints the result; without a judgement, that of an interrupted command.
fn print(search: &Search, judgement: Option<&Judgement>) -> anyhow::Result<()> {
    let best = search.candidates.first();
    let changes = best.map(|best| best.changes.as_str());
    let train = best.map(|_| search.successes());
    let judge = judgement.map(Judgement::successes);
    let pair = |pair: Option<[f64; 2]>| {
        pair.map(|[default, tuned]| json!({ "default": default, "tuned": tuned }))
    };
    let candidates = search.candidates.iter();
    let candidates: Vec<Value> =
        candidates.map(|it| json!({ "changes": it.changes, "success": it.success })).collect();
    let ranked = judgement.map_or(&[][..], |judgement| &judgement.ranked);
    let rows = [&search.rows[..], judgement.map_or(&[], |judgement| &judgement.rows)];
    let faults = rows.map(|rows| fault_text(rows.iter()));
    let object = json!({
        "changes": changes, "train": pair(train), "judge": pair(judge),
        "faults": { "train": faults[0], "judge": faults[1] }, "ranked": ranked, "candidates": candidates,
        "interrupted": machine::is_interrupted(),
    });
    let gain = |name: &str, [default, tuned]: [f64; 2]| {
        format!("{name:<12} default {default:.3}, tuned {tuned:.3}, gain {:+.3}", tuned - default)
    };
    let parts = [(SEARCH, train), (OTHER_WORLDS, judge)];
    let mut lines: Vec<String> =
        parts.iter().filter_map(|&(name, pair)| Some(gain(name, pair?))).collect();
    let others = ranked.iter().filter(|planner| planner.rank > 1);
    lines
        .extend(others.map(|planner| {
            format!("judged       {}: {}", planner.planner, planner.verdict.text())
        }));
    for ((part, successes), (rows, faults)) in parts.into_iter().zip(rows.into_iter().zip(faults)) {
        lines.extend(faults.map(|faults| format!("{part}: faults: {faults}")));
        if successes.is_some() && !has_arrived(rows) {
            lines.push(format!("{part}: no run reached its goal"));
        }
    }
    if judgement.is_none() {
        lines.push(
            "interrupted: the best settings so far are not judged on other worlds".to_owned(),
        );
    } else if changes == Some("") {
        lines.push("no candidate was better than the settings without changes".to_owned());
    }
    lines.extend(changes.unwrap_or_default().lines().map(|line| format!("  {line}")));
    output::result(&object, lines)
}

/// Runs a sweep whose worlds are named as in the file of the plan; with --out each part keeps its results in a folder of its own.
fn runs(
    arguments: &TuneArguments,
    (sweep, file): (&Plan, &Path),
    part: &str,
) -> anyhow::Result<Recorded> {
    let folder = file.parent().unwrap_or(Path::new(""));
    let grid = Grid::new(sweep, folder).with_context(|| file.display().to_string())?;
    let RunArguments { threads, out, record } = &arguments.run;
    let record = record.clone().filter(|_| part == JUDGE);
    let out = out.as_ref().map(|out| out.join(part));
    if let (Some(runner), Some(out)) = (&arguments.runner, &out) {
        run_elsewhere(&runner.program(), (sweep, folder), out)?;
    }
    RunArguments { threads: *threads, out, record }.run(&grid, |_| {})
}

/// Lets a program run the cells of a sweep, whose paths are relative to a folder. The results come into `out`, where the sweep
/// is kept too.
fn run_elsewhere(
    runner: &ProgramSettings,
    (sweep, folder): (&Plan, &Path),
    out: &Path,
) -> anyhow::Result<()> {
    let mut sweep = sweep.clone();
    for path in sweep.worlds.iter_mut().filter_map(|worlds| worlds.path.as_mut()) {
        *path = absolute(folder.join(&path))?;
    }
    machine::interrupt_flag()?;
    let plan = out.join(PLAN);
    fs::create_dir_all(out).with_context(|| format!("--out {}", out.display()))?;
    write_whole(&plan, &toml::to_string(&sweep)?)?;
    let mut command = runner.to_command();
    // What it prints must not get into our result.
    let command = command.arg(plan).arg("--out").arg(out).stdin(Stdio::null()).stdout(io::stderr());
    let status = run_in_group(command, machine::is_interrupted)
        .with_context(|| format!("--runner {runner}: cannot be started"))?;
    ensure!(status.success() || machine::is_interrupted(), "--runner {runner}: {status}");
    Ok(())
}

/// The rows of these settings.
fn of<'r>(rows: &'r [RunRow], config: &str) -> impl Iterator<Item = &'r RunRow> {
    rows.iter().filter(move |row| row.config.as_deref() == Some(config))
}

fn has_arrived(rows: &[RunRow]) -> bool {
    rows.iter().any(RunRow::reached)
}

fn success<'r>(rows: impl Iterator<Item = &'r RunRow>) -> f64 {
    let values: Vec<f64> = rows.map(|row| row.time_weighted_success.unwrap_or_default()).collect();
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

fn changes(text: &str) -> anyhow::Result<Changes> {
    text.parse().map_err(|error: String| anyhow::anyhow!(error))
}
