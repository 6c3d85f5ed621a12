//! `inbye bench dynabarn`.

use clap::Args;
use inbye::experiment::dynabarn::{DynaBarnRow, Summary, Task, dynabarn_config, read_worlds};
use inbye::report::BenchReport;
use serde_json::{Value, json};

use super::config::changed;
use super::worlds::WorldsArguments;
use super::{dynabarn_words, output};

/// `inbye bench dynabarn`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  inbye bench dynabarn --worlds dynabarn --seeds 3 --record moving.csv\n\n\
    The folder holds world_NN.json. The robot, a Jackal, has an empty map and sees the cylinders by its laser alone; they \
    take no notice of it, and jump from the end of their way to its beginning. A run ends when its true pose is within \
    1 m of the goal, on contact, or after 100 s.\n\
    A contact is the robot's if it closed the gap itself, and avoidable if a steady command from 2.5 s before would have \
    kept it clear; the others are shown apart. Success counts every contact as a failure, attributed success leaves out \
    the runs of those others.\n\
    --record keeps a row for each run as it finishes; the same command goes on where it was cut short. This is no Gazebo, \
    but the cylinders go as they do there, on a spline through their keyframes."
)]
pub struct DynaBarnArguments {
    #[command(flatten)]
    pub worlds_of: WorldsArguments,
}

/// Drives the worlds.
pub fn run(arguments: &DynaBarnArguments, json: bool) -> anyhow::Result<bool> {
    let of = &arguments.worlds_of;
    let config = changed(dynabarn_config(), of.config.as_deref())?;
    let worlds = read_worlds(&of.worlds, of.numbers().as_deref())?;
    let tasks = of.tasks(&worlds, |world, seed| Task { world, seed });
    if of.trace.is_some() {
        return of.one_run(
            "DynaBARN",
            &tasks[0],
            &config,
            dynabarn_words::one_run,
            json,
        );
    }
    of.create_folder()?;
    let rows = of.campaign(&tasks, &config)?;
    of.write_report(BenchReport {
        title: "inbye: DynaBARN",
        intro: &format!("Driven in {}.", dynabarn_words::SIMULATOR),
        dynabarn: &rows,
        ..BenchReport::default()
    })?;
    let rows: Vec<&DynaBarnRow> = rows.iter().collect();
    let summary = Summary::of(&rows);
    if json {
        output::json(&object(&summary, &rows)?)?;
    } else {
        dynabarn_words::tables(&summary, &rows)
            .iter()
            .for_each(output::line);
    }
    Ok(true)
}

fn object(summary: &Summary, rows: &[&DynaBarnRow]) -> anyhow::Result<Value> {
    let mut object = serde_json::to_value(summary)?;
    object["simulator"] = json!(dynabarn_words::SIMULATOR);
    object["rows"] = json!(rows);
    Ok(object)
}
