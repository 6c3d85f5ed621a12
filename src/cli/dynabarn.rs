//! `inbye bench dynabarn`.

use std::path::PathBuf;

use clap::Args;
use inbye::bench::barn::RunKey;
use inbye::bench::campaign::{Row, settings_digest};
use inbye::bench::dynabarn::{
    DynaBarnRow, DynaBarnWorld, Summary, Task, drive, dynabarn_config, read_worlds,
};
use inbye::sim::Config;
use serde_json::{Value, json};

use super::arguments::whole;
use super::campaign::Campaign;
use super::changes::changed;
use super::clock::wall_clock;
use super::one_run::{Files, OneRun};
use super::{dynabarn_words, engines, output};

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
    and the cylinders go straight from keyframe to keyframe, where Gazebo lays a spline through them."
)]
pub struct DynaBarnArguments {
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
    /// Make this one run instead, to be looked at, with --svg or --ticks.
    #[arg(long, value_name = "WORLD,SEED", conflicts_with_all = ["only", "seeds", "record"])]
    pub trace: Option<OneRun>,
    /// Draw the run of --trace into this file: what moved, what was planned, what was driven.
    #[arg(long, value_name = "FILE.svg", requires = "trace")]
    pub svg: Option<PathBuf>,
    /// Write every tick of the run of --trace as a line of JSON into this file.
    #[arg(long, value_name = "FILE", requires = "trace")]
    pub ticks: Option<PathBuf>,
}

/// Drives the worlds.
pub fn run(arguments: &DynaBarnArguments, json: bool) -> anyhow::Result<bool> {
    let config = changed(dynabarn_config(), arguments.config.as_deref())?;
    if let Some(OneRun { world, seed }) = arguments.trace {
        let worlds = read_worlds(&arguments.worlds, Some(&[world]))?;
        let world = &worlds[0];
        return trace(arguments, &Task { world, seed }, &config, json);
    }
    let worlds = read_worlds(&arguments.worlds, arguments.only.as_deref())?;
    let tasks = tasks(&worlds, arguments.seeds);
    let campaign = Campaign {
        what: "driving worlds",
        record: arguments.record.as_deref(),
        settings: &settings_digest(&config),
        threads: arguments.threads.unwrap_or_else(engines::cores),
    };
    let work = |task: &Task<'_>| Ok(drive(task, &config, &mut wall_clock())?.0);
    let ledger = campaign.run(&tasks, key, work)?;
    let asked = |row: &&DynaBarnRow| tasks.iter().any(|task| key(task) == row.key());
    let rows: Vec<&DynaBarnRow> = ledger.rows().filter(asked).collect();
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

/// One run, drawn and written tick by tick.
fn trace(
    arguments: &DynaBarnArguments,
    task: &Task<'_>,
    config: &Config,
    json: bool,
) -> anyhow::Result<bool> {
    let files = Files::create(arguments.svg.as_deref(), arguments.ticks.as_deref())?;
    let (row, result) = drive(task, config, &mut wall_clock())?;
    if let Some(result) = &result {
        files.write(&format!("DynaBARN {}", row.key()), &task.mission()?, result)?;
    }
    if json {
        output::json(&row)?;
    } else {
        output::line(dynabarn_words::one_run(&row));
    }
    Ok(true)
}

const fn key(task: &Task<'_>) -> RunKey {
    RunKey {
        world: task.world.number,
        seed: task.seed,
    }
}

fn tasks(worlds: &[DynaBarnWorld], seeds: u64) -> Vec<Task<'_>> {
    let of_world = |world| (0..seeds).map(move |seed| Task { world, seed });
    worlds.iter().flat_map(of_world).collect()
}

fn object(summary: &Summary, rows: &[&DynaBarnRow]) -> anyhow::Result<Value> {
    let mut object = serde_json::to_value(summary)?;
    object["simulator"] = json!(dynabarn_words::SIMULATOR);
    object["rows"] = json!(rows);
    Ok(object)
}
