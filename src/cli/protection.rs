//! `inbye bench protection`.

use std::path::PathBuf;

use clap::Args;
use inbye::experiment::{Grid, Setup, groups};
use inbye::report::BenchReport;
use inbye::sim::WrongPlanner;
use serde_json::json;

use super::arguments::whole;
use super::files::{ReportFolder, all_written};
use super::missions::MissionsArguments;
use super::output;
use super::runs::{group_table, unreached};

const INTRO: &str = "Random missions with a planner that is wrong on purpose: it drives at people and walls at full speed, or at \
    random, or repeats commands of ten seconds ago. Each mission is driven with the protective layer of the sender and without \
    it.";

/// Names of the settings in rows.
const WITH: &str = "with the layer";
const WITHOUT: &str = "without the layer";

/// Time without progress after which a mission ends, seconds: a wrong planner makes none.
const ALLOWANCE_S: f64 = 30.0;

/// `inbye bench protection`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  inbye bench protection --missions 3 --longest 12 --threads 1\n\n\
    The seed of a mission selects its wrong planner: one drives at people and walls at full speed, one commands at random, and one \
    repeats commands of ten seconds ago. Each mission is driven twice: with and without the protective layer of the sender. \
    Missions, people and the cause of a contact are those of `bench soak`.\n\
    JSON fields: `groups`, `sound`, `rows`.\n\
    Exit status 1: a contact caused by the robot in spite of the layer."
)]
pub struct ProtectionArguments {
    #[command(flatten)]
    pub missions_of: MissionsArguments,
    /// Missions, each driven twice.
    #[arg(long, default_value_t = 200, allow_negative_numbers = true, value_parser = whole::<usize>(1, 1_000_000))]
    pub missions: usize,
    /// Write `index.html`, its charts as SVG and its rows as CSV and JSON into this folder.
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
}

/// Drives the missions. False when the robot caused a contact in spite of the layer.
pub fn run(arguments: &ProtectionArguments) -> anyhow::Result<bool> {
    let missions = &arguments.missions_of;
    let report = ReportFolder::create(arguments.report.as_deref())?;
    let (mut config, worlds) = missions.read(0.0)?;
    config.simulation.wrong_planner = WrongPlanner::Mixed;
    config.navigator.movement_time_allowance = ALLOWANCE_S;
    let mut unprotected = config.clone();
    config.collision_monitor.enabled = true;
    unprotected.collision_monitor.enabled = false;
    let setups = [Setup::named(WITH, config), Setup::named(WITHOUT, unprotected)];
    let count = arguments.missions;
    let grid = Grid::of_missions("protection", &worlds, &setups, count, missions.seed)?;
    let (rows, recorded) = missions.drive(&grid)?;
    let mut table = groups(&rows);
    for group in &mut table {
        group.name = group.config.clone().unwrap_or_default();
    }
    let is_protected = |name: &Option<String>| name.as_deref() == Some(WITH);
    let mut protected = table.iter().filter(|group| is_protected(&group.config));
    let is_sound = protected.all(|group| group.contacts_robot == 0);
    let contacts =
        rows.iter().filter(|row| is_protected(&row.config) && row.contact_cause.is_some());
    let lines = group_table(&table).into_iter().chain(unreached(contacts));
    let object = json!({ "groups": table, "sound": is_sound, "rows": rows });
    output::result(&object, lines)?;
    let reported = report.write_bench(BenchReport {
        title: "inbye: the protective layer against wrong planners",
        intro: INTRO,
        protection: &rows,
        ..BenchReport::default()
    });
    all_written([recorded, reported])?;
    Ok(is_sound)
}
