//! The demo on built-in scenes: `inbye` without a command.

use std::path::PathBuf;
use std::sync::Arc;

use inbye::bench::{Density, DensityPlan, crossovers, verify};
use inbye::local::{Engine, EngineChoice, SelectedEngine, open_with_fallback};
use inbye::navigator::Goal;
use inbye::report::{EngineComparison, MissionView, PlaybackRecorder, Report, html};
use inbye::runtime::{Config, Mission, MissionResult};
use inbye::sim::{Scene, Simulation, scenes};
use serde_json::json;

use super::command::Arguments;
use super::{bench, density_text, drive, engines, output, report_file};

/// Default folder of the report.
const FOLDER: &str = "inbye-report";
/// Problems for the comparison of engines.
const CASES: u64 = 100;
/// Seed of the problems: the default of `inbye verify`.
const SEED: u64 = 1;
/// Horizon, range of samples and time of the density measurement.
const STEPS: u32 = 40;
const SAMPLES: (usize, usize) = (256, 16_384);
const SECONDS: f64 = 0.15;
/// Time limit per measurement: a software adapter would dominate the demo otherwise.
const MAX_SECONDS: f64 = 1.5;
/// Reference sampling and number of decisions of the quality measurement: fewer than those of `inbye bench density`.
const DENSEST: usize = 1 << 18;
const TICKS: usize = 25;

const INTRO: &str = "Three built-in scenes: a global path is searched, pruned and smoothed, then driven in a closed loop among \
    pedestrians by the dynamic window approach.\n\n\
    Then every engine of this machine: the same problems compared bit for bit, and sampling density against decision time \
    and quality of the command.";

/// Plans, drives, compares engines, measures and writes the report. Returns false if a goal was missed or bits differ.
pub fn run(arguments: &Arguments) -> anyhow::Result<bool> {
    let default = || PathBuf::from(FOLDER);
    let folder = arguments.report.clone().unwrap_or_else(default);
    report_file::create_folder(&folder)?;
    let config = Config::default();
    let mut drives = Vec::new();
    for scene in scenes() {
        let SelectedEngine { engine, reason } =
            open_with_fallback(&EngineChoice::Auto, engines::cores(), false)?;
        if drives.is_empty() {
            output::note(format!("engine: {reason}"));
        }
        let (simulation, result, playback) = drive_scene(&scene, &config, engine)?;
        if !arguments.json {
            output::line(format!("{:12} {}", scene.name, drive::one_line(&result)));
        }
        let facts = report_file::facts(&result);
        drives.push((scene, simulation, result, playback, facts));
    }
    let mut all = engines::all()?;
    let bar = output::progress(CASES, "comparing engines");
    let verification = verify(&mut all, CASES, SEED, |done| bar.set_position(done))?;
    bar.finish_and_clear();
    let agree = verification.agree();
    let comparisons: Vec<EngineComparison> = all
        .iter()
        .zip(&verification.digests)
        .map(|(engine, digest)| EngineComparison {
            name: engine.name(),
            digest: digest.clone(),
            agrees: *digest == verification.digests[0],
        })
        .collect();
    let plan = DensityPlan {
        max_seconds: MAX_SECONDS,
        ..DensityPlan::powers_of_four(STEPS, SAMPLES.0, SAMPLES.1, SECONDS)
    };
    let Density { rows, skipped } = bench::measure(&mut all, &plan)?;
    let quality = bench::compare(&plan, DENSEST, TICKS)?;
    let crossovers = crossovers(&rows);
    let machine = engines::machine();
    let page = html(&Report {
        title: "inbye: the demo",
        intro: INTRO,
        machine: &machine,
        missions: drives
            .iter()
            .map(|(scene, simulation, result, playback, facts)| MissionView {
                title: scene.title,
                command: "inbye",
                mission: &simulation.mission,
                config: &config,
                result,
                playback: Some(playback),
                facts,
            })
            .collect(),
        comparisons: &comparisons,
        density: &rows,
        skipped: &skipped,
        quality: &quality,
        density_command: "inbye bench density",
    });
    report_file::write(&folder, &page)?;
    let reached = drives.iter().all(|(_, _, result, ..)| result.reached && !result.collided);
    if arguments.json {
        let missions: Vec<_> = drives
            .iter()
            .map(|(scene, _, result, ..)| {
                let mut object = drive::object(result);
                object["scene"] = json!(scene.name);
                object
            })
            .collect();
        output::json(&json!({
            "missions": missions,
            "cases": verification.cases,
            "agree": agree,
            "rows": rows,
            "skipped": skipped,
            "crossover": crossovers,
            "quality": quality,
            "report": folder.join("index.html"),
        }))?;
    } else {
        let (count, cases) = (all.len(), verification.cases);
        output::line(if agree {
            format!("{count} engines returned the same bits for {cases} problems")
        } else {
            format!("the engines DIFFER: run `inbye verify --cases {cases} --seed {SEED}`")
        });
        density_text::density(&rows, &skipped, &crossovers)
            .iter()
            .chain(&density_text::quality(&quality))
            .for_each(output::line);
    }
    Ok(reached && agree)
}

fn drive_scene(
    scene: &Scene,
    config: &Config,
    engine: Box<dyn Engine>,
) -> anyhow::Result<(Simulation, MissionResult, PlaybackRecorder)> {
    let (start, goal) = (scene.start, scene.goal);
    let ends = (start.position(), goal);
    let spawner = config.simulation.pedestrians.spawner(scene.obstacles, scene.seed);
    let goal = Goal { position: goal, yaw: None };
    let simulation = Simulation {
        moving_obstacles: spawner.spawn_on_route(&scene.map, config, ends)?,
        seed: scene.seed,
        ..Simulation::new(Mission {
            time_limit_s: 600.0,
            ..Mission::new(Arc::new(scene.map.clone()), start, goal)
        })
    };
    let mut playback = PlaybackRecorder::default();
    let result =
        drive::drive(&simulation, config, engine, scene.name, None, Some(&mut playback), None)?;
    Ok((simulation, result, playback))
}
