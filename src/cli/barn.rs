//! `inbye bench barn`.

use clap::Args;
use inbye::experiment::barn::{BarnRow, Summary, Task, barn_config, read_worlds};
use inbye::report::BenchReport;
use serde_json::{Value, json};

use super::arguments::number;
use super::config::changed;
use super::worlds::WorldsArguments;
use super::{barn_words, output};

/// `inbye bench barn`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  inbye bench barn --worlds barn --seeds 3 --record runs.csv\n  inbye bench barn --worlds barn --report report\n\n\
    The folder holds worlds.csv and worlds/world_NNN.csv. The robot, a Jackal, has an empty map and sees the cylinders by \
    its laser alone. A run ends when its true pose is within 1 m of the goal, on contact, or after 100 s; its score is \
    OT / clip(T, 2 OT, 8 OT) if it arrived, else 0, where OT is what the benchmark's path takes at 2 m/s.\n\
    --record keeps a row for each run as it finishes; the same command goes on where it was cut short. The published \
    figures were measured in Gazebo, which this simulator is not."
)]
pub struct BarnArguments {
    #[command(flatten)]
    pub worlds_of: WorldsArguments,
    /// Highest speed, m/s; 0.5 is that of the published baseline.
    #[arg(long, default_value_t = 2.0, allow_negative_numbers = true, value_parser = speed)]
    pub max_speed: f64,
}

fn speed(text: &str) -> Result<f64, String> {
    let fits = |speed: f64| speed > 0.0 && speed <= 10.0;
    number(text, fits, "metres per second, above zero and at most 10")
}

/// Drives the worlds.
pub fn run(arguments: &BarnArguments, json: bool) -> anyhow::Result<bool> {
    let of = &arguments.worlds_of;
    let config = changed(barn_config(arguments.max_speed), of.config.as_deref())?;
    let worlds = read_worlds(&of.worlds, of.numbers().as_deref())?;
    let tasks = of.tasks(&worlds, Task::barn);
    if of.trace.is_some() {
        return of.one_run("BARN", &tasks[0], &config, barn_words::one_run, json);
    }
    of.create_folder()?;
    let rows = of.campaign(&tasks, &config)?;
    of.write_report(BenchReport {
        title: "inbye: BARN",
        intro: &format!(
            "Driven at up to {} m/s in {}.",
            arguments.max_speed,
            barn_words::SIMULATOR
        ),
        barn: &rows,
        ..BenchReport::default()
    })?;
    let rows: Vec<&BarnRow> = rows.iter().collect();
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

fn object(summary: &Summary, rows: &[&BarnRow], max_speed: f64) -> anyhow::Result<Value> {
    let mut object = serde_json::to_value(summary)?;
    object["max_speed"] = json!(max_speed);
    object["simulator"] = json!(barn_words::SIMULATOR);
    object["rows"] = json!(rows);
    Ok(object)
}
