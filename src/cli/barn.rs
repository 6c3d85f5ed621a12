//! `inbye bench barn`.

use clap::Args;
use inbye::experiment::World;
use inbye::experiment::barn::{BarnSummary, OverWorlds, barn_config, read_worlds};
use inbye::report::BenchReport;
use serde_json::json;

use super::arguments::number;
use super::config::changed;
use super::output;
use super::run_text::{group_table, unreached};
use super::worlds::WorldsArguments;

/// Limits of a comparison with published figures.
const SIMULATOR: &str = "inbye's own planar simulator, not Gazebo: no physics engine, but slip, lag, drift and noise; contacts are exact";

/// `inbye bench barn`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  inbye bench barn --worlds barn --seeds 3 --out runs --record runs.csv\n  inbye bench barn --worlds barn --report report\n\n\
    The folder holds worlds.csv and worlds/world_NNN.csv. The robot, a Jackal, has an empty map and sees the cylinders only \
    with its laser. A run ends when its true pose is within 1 m of the goal, on contact, or after 100 s; its score is \
    OT / clip(T, 2 OT, 8 OT) if it arrived, else 0, where OT is the time of the benchmark's path at 2 m/s.\n\
    With --out the same command resumes where it was interrupted. The published figures were measured in Gazebo, not in this \
    simulator.\n\
    JSON fields: `summary`, `max_speed`, `simulator`, `rows`."
)]
pub struct BarnArguments {
    #[command(flatten)]
    pub worlds_of: WorldsArguments,
    /// Highest speed, m/s; the published baseline has 0.5.
    #[arg(long, default_value_t = 2.0, allow_negative_numbers = true, value_parser = speed)]
    pub max_speed: f64,
}

fn speed(text: &str) -> Result<f64, String> {
    let fits = |speed: f64| speed > 0.0 && speed <= 10.0;
    number(text, fits, "metres per second, above zero and at most 10")
}

/// Drives the worlds.
pub fn run(arguments: &BarnArguments, json: bool) -> anyhow::Result<bool> {
    let (of, max_speed) = (&arguments.worlds_of, arguments.max_speed);
    let config = changed(barn_config(max_speed), of.config.as_deref())?;
    let listed = read_worlds(&of.worlds, of.numbers().as_deref())?;
    let world = |world: &_| World::barn(Clone::clone(world), max_speed);
    let worlds: Vec<World> = listed.iter().map(world).collect();
    if let Some(run) = of.trace {
        return of.one_run(run, "BARN", &worlds[0], &config, json);
    }
    let intro = format!("Driven at up to {max_speed} m/s in {SIMULATOR}.");
    let rows = of.drive(("BARN", &intro), &worlds, &config, |rows| BenchReport {
        title: "inbye: BARN",
        barn: rows,
        ..BenchReport::default()
    })?;
    let summary = BarnSummary::of(&rows, &listed);
    if json {
        output::json(&json!({
            "summary": summary,
            "max_speed": max_speed,
            "simulator": SIMULATOR,
            "rows": rows,
        }))?;
    } else {
        let lines = text(&summary, max_speed).into_iter();
        lines.chain(unreached(&rows)).for_each(output::line);
    }
    Ok(true)
}

fn text(summary: &BarnSummary, max_speed: f64) -> Vec<String> {
    let mut lines = group_table(core::slice::from_ref(&summary.all));
    let means = |title: &str, means: &OverWorlds| {
        let OverWorlds { worlds, success, score, .. } = means;
        format!("{title}: {worlds} worlds, success {success:.3}, score {score:.4}")
    };
    let here = format!("here, {max_speed} m/s at most");
    lines.push(means(&here, &summary.over_worlds));
    let official = summary.official.as_ref();
    lines.extend(official.map(|official| means("  official worlds of these", official)));
    if let Some(published) = &summary.published {
        lines.push(format!(
            "  published there, DWA 0.5 m/s: {} worlds, success {:.3}, score {:.4}, {:.1} % collided, {:.1} % out of time",
            published.worlds,
            published.success,
            published.score,
            published.collided * 100.0,
            published.timeout * 100.0
        ));
        lines.push(format!(
            "The published figures were measured in Gazebo; the others in {SIMULATOR}."
        ));
    }
    lines
}
