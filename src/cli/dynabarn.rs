//! `inbye bench dynabarn`.

use clap::Args;
use inbye::experiment::dynabarn::{dynabarn_config, read_worlds};
use inbye::experiment::{Group, World};
use inbye::report::BenchReport;
use serde_json::json;

use super::config::changed;
use super::output;
use super::run_text::{group_table, unreached};
use super::worlds::WorldsArguments;

/// Limits of a comparison with published figures.
const SIMULATOR: &str = "inbye's own planar simulator, not Gazebo: no physics engine, but slip, lag, drift and \
    noise; contacts are exact; the cylinders move as in Gazebo, on a spline through their keyframes";

/// `inbye bench dynabarn`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  inbye bench dynabarn --worlds dynabarn --seeds 3 --out moving --record moving.csv\n\n\
    The folder holds world_NN.json. The robot, a Jackal, has an empty map and sees the cylinders only with its laser; they \
    ignore the robot, and jump from the end of their path to its start. A run ends when its true pose is within 1 m of the \
    goal, on contact, or after 100 s.\n\
    The robot causes a contact if it closed the gap itself; a contact is avoidable if a constant command from 2.5 s before it \
    stays clear. `reached_share` counts every contact as a failure, `attributed_share` leaves out the runs with other \
    contacts.\n\
    With --out the same command resumes where it was interrupted. This simulator is not Gazebo, but the cylinders move as in \
    Gazebo, on a spline through their keyframes.\n\
    JSON fields: `summary`, `simulator`, `rows`."
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
    let worlds: Vec<World> = worlds.into_iter().map(World::dynabarn).collect();
    if let Some(run) = of.trace {
        return of.one_run(run, "DynaBARN", &worlds[0], &config, json);
    }
    let intro = format!("Driven in {SIMULATOR}.");
    let rows = of.drive(("DynaBARN", &intro), &worlds, &config, |rows| BenchReport {
        title: "inbye: DynaBARN",
        dynabarn: rows,
        ..BenchReport::default()
    })?;
    let summary = Group::of("all", &rows.iter().collect::<Vec<_>>());
    if json {
        output::json(&json!({ "summary": summary, "simulator": SIMULATOR, "rows": rows }))?;
        return Ok(true);
    }
    let attributed = summary.attributed_share;
    let attributed = attributed.map_or_else(|| "none".to_owned(), |share| format!("{share:.3}"));
    let lines = group_table(&[summary]).into_iter();
    let notes = [
        format!(
            "success without the runs whose contact the robot neither caused nor could avoid: {attributed}"
        ),
        format!("Driven in {SIMULATOR}."),
    ];
    lines.chain(notes).chain(unreached(&rows)).for_each(output::line);
    Ok(true)
}
