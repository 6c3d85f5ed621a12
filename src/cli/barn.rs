//! `inbye bench barn`.

use std::path::PathBuf;

use clap::Args;
use inbye::bench::barn::{
    BarnRow, BarnWorld, RunKey, Summary, Task, barn_config, drive, read_worlds,
};
use inbye::bench::campaign::{Row, settings_digest};
use inbye::sim::Config;
use serde_json::{Value, json};

use super::arguments::{number, whole};
use super::campaign::Campaign;
use super::changes::changed;
use super::clock::wall_clock;
use super::one_run::{Files, OneRun};
use super::{barn_words, engines, output};

/// `inbye bench barn`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  inbye bench barn --worlds barn --seeds 3 --record runs.csv\n\n\
    The folder holds worlds.csv and worlds/world_NNN.csv. The robot, a Jackal, has an empty map and sees the cylinders by \
    its laser alone. A run ends when its true pose is within 1 m of the goal, on contact, or after 100 s; its score is \
    OT / clip(T, 2 OT, 8 OT) if it arrived, else 0, where OT is what the benchmark's path takes at 2 m/s.\n\
    --record keeps a row for each run as it finishes; the same command goes on where it was cut short. The published \
    figures were measured in Gazebo, which this simulator is not."
)]
pub struct BarnArguments {
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
    /// Highest speed, m/s; 0.5 is that of the published baseline.
    #[arg(long, default_value_t = 2.0, allow_negative_numbers = true, value_parser = speed)]
    pub max_speed: f64,
    /// Settings that shall differ from the benchmark's, TOML.
    #[arg(long, value_name = "FILE.toml")]
    pub config: Option<PathBuf>,
    /// Keep a row for each run in this file, and go on where it ends.
    #[arg(long, value_name = "FILE.csv")]
    pub record: Option<PathBuf>,
    /// Make this one run instead, to be looked at, with --svg or --ticks.
    #[arg(long, value_name = "WORLD,SEED", conflicts_with_all = ["only", "seeds", "record"])]
    pub trace: Option<OneRun>,
    /// Draw the run of --trace into this file: what stands there, what was planned, what was driven.
    #[arg(long, value_name = "FILE.svg", requires = "trace")]
    pub svg: Option<PathBuf>,
    /// Write every tick of the run of --trace as a line of JSON into this file.
    #[arg(long, value_name = "FILE", requires = "trace")]
    pub ticks: Option<PathBuf>,
}

fn speed(text: &str) -> Result<f64, String> {
    let fits = |speed: f64| speed > 0.0 && speed <= 10.0;
    number(text, fits, "metres per second, above zero and at most 10")
}

/// Drives the worlds.
pub fn run(arguments: &BarnArguments, json: bool) -> anyhow::Result<bool> {
    let config = changed(
        barn_config(arguments.max_speed),
        arguments.config.as_deref(),
    )?;
    if let Some(OneRun { world, seed }) = arguments.trace {
        let worlds = read_worlds(&arguments.worlds, Some(&[world]))?;
        return trace(arguments, &Task::barn(&worlds[0], seed), &config, json);
    }
    let worlds = read_worlds(&arguments.worlds, arguments.only.as_deref())?;
    let tasks = tasks(&worlds, arguments.seeds);
    let campaign = Campaign {
        what: "driving worlds",
        record: arguments.record.as_deref(),
        settings: &settings_digest(&config),
        threads: arguments.threads.unwrap_or_else(engines::cores),
    };
    let work = |task: &Task| Ok(drive(task, &config, &mut wall_clock())?.0);
    let ledger = campaign.run(&tasks, key, work)?;
    let asked = |row: &&BarnRow| tasks.iter().any(|task| key(task) == row.key());
    let rows: Vec<&BarnRow> = ledger.rows().filter(asked).collect();
    let summary = Summary::of(&rows, &worlds);
    if json {
        output::json(&object(&summary, &rows, arguments.max_speed)?)?;
    } else {
        barn_words::tables(&summary, &rows, arguments.max_speed)
            .iter()
            .for_each(output::line);
    }
    Ok(true)
}

/// One run, drawn and written tick by tick.
fn trace(
    arguments: &BarnArguments,
    task: &Task,
    config: &Config,
    json: bool,
) -> anyhow::Result<bool> {
    let files = Files::create(arguments.svg.as_deref(), arguments.ticks.as_deref())?;
    let (row, result) = drive(task, config, &mut wall_clock())?;
    if let Some(result) = &result {
        files.write(&format!("BARN {}", row.key()), &task.mission()?, result)?;
    }
    if json {
        output::json(&row)?;
    } else {
        output::line(barn_words::one_run(&row));
    }
    Ok(true)
}

const fn key(task: &Task) -> RunKey {
    RunKey {
        world: task.world,
        seed: task.seed,
    }
}

fn tasks(worlds: &[BarnWorld], seeds: u64) -> Vec<Task> {
    let of_world = |world| (0..seeds).map(move |seed| Task::barn(world, seed));
    worlds.iter().flat_map(of_world).collect()
}

fn object(summary: &Summary, rows: &[&BarnRow], max_speed: f64) -> anyhow::Result<Value> {
    let mut object = serde_json::to_value(summary)?;
    object["max_speed"] = json!(max_speed);
    object["simulator"] = json!(barn_words::SIMULATOR);
    object["rows"] = json!(rows);
    Ok(object)
}
