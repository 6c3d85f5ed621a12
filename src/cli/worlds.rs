//! `inbye bench barn` and `inbye bench dynabarn`: numbered worlds, each driven with several seeds.

use std::path::PathBuf;
use std::slice;
use std::str::FromStr;

use anyhow::bail;
use clap::Args;
use inbye::experiment::barn::{self, BarnSummary, OverWorlds, barn_config};
use inbye::experiment::dynabarn::{self, dynabarn_config};
use inbye::experiment::{Grid, Group, Setup, World, check_programs};
use inbye::local::CpuEngine;
use inbye::report::{BenchReport, DriveView, drive_svg};
use inbye::runtime::{Config, MissionResult, Observer};
use inbye::sim::Simulation;
use inbye::suggest::counted;
use serde_json::json;

use super::arguments::{above_zero, real, whole};
use super::config::changed;
use super::drive_text::one_line;
use super::files::{Output, ReportFolder, all_written, open_file};
use super::machine::wall_clock;
use super::own_programs::ProgramArguments;
use super::runs::{Recorded, RunArguments, group_table, run_name, run_text, unreached};
use super::{output, recording};

/// Limits of a comparison of BARN with published figures.
const BARN_SIMULATOR: &str = "inbye's own planar simulator, not Gazebo: no physics engine, but slip, lag, drift and noise; contacts are exact";
/// Limits of a comparison of `DynaBARN` with published figures.
const DYNABARN_SIMULATOR: &str = "inbye's own planar simulator, not Gazebo: no physics engine, but slip, lag, drift and \
    noise; contacts are exact; the cylinders move as in Gazebo, on a spline through their keyframes";

/// Worlds and seeds to drive, and where results go.
#[derive(Debug, Args)]
pub struct WorldsArguments {
    /// The folder of worlds.
    #[arg(long, value_name = "DIR")]
    pub worlds: PathBuf,
    /// Only these worlds, by their numbers [default: all].
    #[arg(long, value_name = "12,18", value_delimiter = ',', value_parser = whole::<u32>(0, u64::from(u32::MAX)))]
    pub only: Option<Vec<u32>>,
    /// Seeds of noise, from 0, with which each world is driven.
    #[arg(long, default_value_t = 1, allow_negative_numbers = true, value_parser = whole::<u64>(1, 1_000_000))]
    pub seeds: u64,
    #[command(flatten)]
    pub programs: ProgramArguments,
    #[command(flatten)]
    pub run: RunArguments,
    /// Settings that differ from the benchmark's, TOML.
    #[arg(long, value_name = "FILE.toml")]
    pub config: Option<PathBuf>,
    /// Write `index.html`, the chart by world as SVG and its rows as CSV and JSON into this folder.
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
    /// Make only this run, for --svg or --ticks.
    // The other flags require the group: clap drops the requirement of a flag that conflicts with another given flag.
    #[arg(
        long,
        value_name = "WORLD,SEED",
        group = "one_run",
        conflicts_with_all = ["only", "seeds", "record", "report", "out"]
    )]
    pub trace: Option<OneRun>,
    /// Draw the run of --trace into this file: obstacles, plans and the path driven.
    #[arg(long, value_name = "FILE.svg", requires = "one_run")]
    pub svg: Option<PathBuf>,
    /// Write every tick of the run of --trace as a line of JSON into this file.
    #[arg(long, value_name = "FILE", requires = "one_run")]
    pub ticks: Option<PathBuf>,
}

/// Selects a run.
#[derive(Clone, Copy, Debug)]
pub struct OneRun {
    /// The world's number.
    pub world: u32,
    /// Seed of the noise.
    pub seed: u64,
}

impl FromStr for OneRun {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (world, seed) = text.split_once(',').ok_or("write WORLD,SEED, such as 12,0")?;
        Ok(Self { world: whole(0, u64::from(u32::MAX))(world)?, seed: whole(0, u64::MAX)(seed)? })
    }
}

impl WorldsArguments {
    /// Numbers of the worlds to read; none for all.
    fn numbers(&self) -> Option<Vec<u32>> {
        self.trace.map_or_else(|| self.only.clone(), |run| Some(vec![run.world]))
    }

    /// Drives all worlds with all seeds, and writes the record. Returns the rows, by world and seed, with the folder of the report.
    fn drive(
        &self,
        title: &str,
        worlds: &[World],
        config: Config,
    ) -> anyhow::Result<(Recorded, ReportFolder<'_>)> {
        let folder = ReportFolder::create(self.report.as_deref())?;
        let seeds: Vec<u64> = (0..self.seeds).collect();
        let grid = Grid::of_worlds(title, worlds, &[Setup::unnamed(config)], &seeds)?;
        Ok((self.run.run(&grid, |_| {})?, folder))
    }

    /// Makes the run of `--trace`: draws it, writes its ticks, and prints it as text or JSON.
    fn one_run(
        &self,
        run: OneRun,
        title: &str,
        world: &World,
        config: &Config,
    ) -> anyhow::Result<bool> {
        let setup = Setup::unnamed(config.clone());
        let grid = Grid::of_worlds(title, slice::from_ref(world), &[setup], &[run.seed])?;
        check_programs(&grid.cells)?;
        let svg = Output::create("--svg", self.svg.as_deref(), &["svg"])?;
        let ticks = self.ticks.as_deref().map(|name| open_file("--ticks", name)).transpose()?;
        let mut observer = Observer { clock: &mut wall_clock(), on_tick: &mut |_| {} };
        let engine = Box::new(CpuEngine::single_threaded());
        let driven = world.drive(run.seed, config, engine, &mut observer)?;
        output::result(&driven.row, [run_text(&driven.row)])?;
        if let (Some(drawn), Some(result)) = (&driven.simulation, &driven.result) {
            let title = format!("{title} {}", run_name(&driven.row));
            svg.write(|| picture(&title, &drawn.simulation, result))?;
            if let Some(file) = ticks {
                recording::write_ticks("--ticks", file, result)?;
            }
        }
        Ok(true)
    }
}

/// Draws a run on the true map.
fn picture(title: &str, simulation: &Simulation, result: &MissionResult) -> String {
    let solid = |&blocked: &bool| if blocked { 100 } else { 0 };
    let mission = &simulation.mission;
    let truth = simulation.truth.as_ref().map(|truth| truth.map(solid));
    drive_svg(&DriveView {
        title,
        caption: &one_line(result),
        map: truth.as_ref().unwrap_or(&mission.map),
        zones: mission.zones.as_deref(),
        start: mission.start,
        goal: mission.goal.position,
        trace: &result.trace,
    })
}

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
    #[arg(long, default_value_t = 2.0, allow_negative_numbers = true, value_parser = real(above_zero(10.0), "metres per second, above zero and at most 10"))]
    pub max_speed: f64,
}

/// The simulator of a configuration, and its limits.
fn barn_simulator(config: &Config) -> String {
    let program = config.simulator.name();
    program.map_or_else(
        || BARN_SIMULATOR.to_owned(),
        |name| format!("the simulator `{name}`, not Gazebo"),
    )
}

/// Drives the worlds of BARN.
pub fn barn(arguments: &BarnArguments) -> anyhow::Result<bool> {
    let (of, max_speed) = (&arguments.worlds_of, arguments.max_speed);
    let mut config = changed(barn_config(max_speed), of.config.as_deref())?;
    of.programs.set(&mut config);
    let listed = barn::read_worlds(&of.worlds, of.numbers().as_deref())?;
    let world = |world: &_| World::barn(Clone::clone(world), max_speed);
    let worlds: Vec<World> = listed.iter().map(world).collect();
    if let Some(run) = of.trace {
        return of.one_run(run, "BARN", &worlds[0], &config);
    }
    let simulator = barn_simulator(&config);
    let intro = format!("Driven at up to {max_speed} m/s in {simulator}.");
    let ((rows, recorded), folder) = of.drive("BARN", &worlds, config)?;
    let summary = BarnSummary::of(&rows, &listed);
    let lines = barn_text(&summary, max_speed, &simulator).into_iter().chain(unreached(&rows));
    let object = json!({
        "summary": summary, "max_speed": max_speed, "simulator": simulator, "rows": rows,
    });
    output::result(&object, lines)?;
    let reported = folder.write_bench(BenchReport {
        title: "inbye: BARN",
        intro: &intro,
        barn: &rows,
        ..BenchReport::default()
    });
    all_written([recorded, reported])?;
    Ok(true)
}

fn barn_text(summary: &BarnSummary, max_speed: f64, simulator: &str) -> Vec<String> {
    let mut lines = group_table(slice::from_ref(&summary.all));
    let means = |title: &str, means: &OverWorlds| {
        let OverWorlds { worlds, success, score, .. } = means;
        format!("{title}: {}, success {success:.3}, score {score:.4}", counted(*worlds, "world"))
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
            "The published figures were measured in Gazebo; the others in {simulator}."
        ));
    }
    lines
}

/// `inbye bench dynabarn`.
#[derive(Debug, Args)]
#[command(
    // Its cylinders are not in the world of another simulator.
    mut_arg("simulator", |argument| argument.hide(true)),
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

/// Drives the worlds of `DynaBARN`.
pub fn dynabarn(arguments: &DynaBarnArguments) -> anyhow::Result<bool> {
    let of = &arguments.worlds_of;
    let mut config = changed(dynabarn_config(), of.config.as_deref())?;
    of.programs.set(&mut config);
    if config.simulator.is_set() {
        let place = match &of.config {
            Some(file) if of.programs.simulator.is_none() => {
                format!("{}: [simulator]", file.display())
            }
            _ => "--simulator".to_owned(),
        };
        bail!(
            "{place}: the cylinders of DynaBARN move only in inbye's own simulator: leave it out"
        );
    }
    let worlds = dynabarn::read_worlds(&of.worlds, of.numbers().as_deref())?;
    let worlds: Vec<World> = worlds.into_iter().map(World::dynabarn).collect();
    if let Some(run) = of.trace {
        return of.one_run(run, "DynaBARN", &worlds[0], &config);
    }
    let intro = format!("Driven in {DYNABARN_SIMULATOR}.");
    let ((rows, recorded), folder) = of.drive("DynaBARN", &worlds, config)?;
    let summary = Group::of("all", &rows);
    let object = json!({ "summary": summary, "simulator": DYNABARN_SIMULATOR, "rows": rows });
    let attributed = summary.attributed_share;
    let attributed = attributed.map_or_else(|| "none".to_owned(), |share| format!("{share:.3}"));
    let mut lines = group_table(&[summary]);
    lines.push(format!(
        "success without the runs whose contact the robot neither caused nor could avoid: {attributed}"
    ));
    lines.push(intro.clone());
    output::result(&object, lines.into_iter().chain(unreached(&rows)))?;
    let reported = folder.write_bench(BenchReport {
        title: "inbye: DynaBARN",
        intro: &intro,
        dynabarn: &rows,
        ..BenchReport::default()
    });
    all_written([recorded, reported])?;
    Ok(true)
}
