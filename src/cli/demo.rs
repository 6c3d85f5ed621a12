//! The demo on built-in scenes: `inbye` without a command.

use std::path::Path;

use inbye::bench::{DensityPlan, EngineRequest, crossovers, verify};
use inbye::local::{CpuEngines, Engine};
use inbye::report::{EngineComparison, MissionView, PlaybackRecorder, Report, html};
use inbye::runtime::{Config, MissionResult};
use inbye::sim::{Scene, Simulation, mine, scenes};
use serde_json::json;

use super::arguments::decision_size;
use super::drive::DriveObservers;
use super::files::ReportFolder;
use super::{Arguments, density, drive, drive_text, engine_selection, machine, output};

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

const INTRO: &str = "Four built-in scenes: a global path is searched, pruned and smoothed, then driven in a closed loop among \
    pedestrians by the dynamic window approach.\n\n\
    Then every engine of this machine: the same problems compared bit for bit, and sampling density against decision time \
    and quality of the command.";

/// Plans, drives, compares engines, measures and writes the report. Returns false if a goal was missed, bits
/// differ, or a GPU was lost.
pub fn run(arguments: &Arguments) -> anyhow::Result<bool> {
    let folder = arguments.report.as_deref().unwrap_or(Path::new(FOLDER));
    let report = ReportFolder::create(Some(folder))?;
    let config = Config::default();
    let mut drives = Vec::new();
    for scene in [mine()].into_iter().chain(scenes()) {
        let size = decision_size(&config);
        let (request, cores) = (EngineRequest::Auto, machine::cores());
        let engine = engine_selection::open_to_drive(&request, &size, cores, false)?;
        let drive = Drive::new(scene, &config, engine)?;
        if !output::is_json() {
            let text = drive_text::coloured_line(&drive.result);
            output::line(format!("{:12} {text}", drive.scene.name));
        }
        drives.push(drive);
    }
    let mut all = machine::engines(CpuEngines::OneAndAll)?.open;
    let bar = output::progress(CASES, "comparing engines", "problems");
    let verification = verify(&mut all, CASES, SEED, |done| bar.set_position(done))?;
    bar.finish_and_clear();
    let agree = verification.agree();
    let compared = all.iter().zip(&verification.digests).map(|(engine, digest)| EngineComparison {
        name: engine.name(),
        digest: digest.clone(),
        agrees: *digest == verification.digests[0],
    });
    let comparisons: Vec<_> = compared.collect();
    let plan = DensityPlan {
        max_seconds: MAX_SECONDS,
        ..DensityPlan::powers_of_four(STEPS, SAMPLES.0, SAMPLES.1, SECONDS)
    };
    let measured = density::measure(&mut all, &plan)?;
    let quality = density::compare(&plan, DENSEST, TICKS)?;
    let (count, cases) = (all.len(), verification.cases);
    let mut lines = vec![if agree {
        let text = format!("{count} engines returned the same bits for {cases} problems");
        output::good(&text)
    } else {
        let cure = format!("run `inbye verify --cases {cases} --seed {SEED}`");
        format!("{}: {cure}", output::bad("the engines DIFFER"))
    }];
    lines.extend(density::text(&measured, &quality));
    let mission = |drive: &Drive| {
        let mut object = drive_text::object(&drive.result);
        object["scene"] = json!(drive.scene.name);
        object
    };
    let object = json!({
        "missions": drives.iter().map(mission).collect::<Vec<_>>(),
        "cases": cases,
        "agree": agree,
        "rows": measured.rows,
        "skipped": measured.skipped,
        "lost": measured.lost,
        "crossover": crossovers(&measured.rows),
        "quality": quality,
        "report": folder.join("index.html"),
    });
    output::result(&object, lines)?;
    report.write_page(|| {
        html(&Report {
            title: "inbye: the demo",
            intro: INTRO,
            machine: &machine::description(),
            missions: drives.iter().map(|drive| drive.view(&config)).collect(),
            comparisons: &comparisons,
            density: &measured.rows,
            skipped: &measured.skipped,
            quality: &quality,
            density_command: "inbye bench density",
        })
    })?;
    let reached = drives.iter().all(|drive| drive.result.reached && !drive.result.collided);
    Ok(reached && agree && measured.lost.is_empty())
}

/// A drive through a built-in scene.
struct Drive {
    scene: Scene,
    simulation: Simulation,
    result: MissionResult,
    playback: PlaybackRecorder,
    facts: Vec<(String, String)>,
    /// The command that repeats the drive alone.
    command: String,
}

impl Drive {
    fn new(scene: Scene, config: &Config, engine: Box<dyn Engine>) -> anyhow::Result<Self> {
        let spawner = config.simulation.pedestrians.spawner(scene.obstacles, scene.seed);
        let mission = scene.mission(600.0);
        let simulation = Simulation {
            moving_obstacles: spawner.spawn_on_route(&mission, config)?,
            seed: scene.seed,
            ..Simulation::new(mission)
        };
        let mut playback = PlaybackRecorder::default();
        let observers = DriveObservers { playback: Some(&mut playback), ..Default::default() };
        let result = drive::drive(&simulation, config, engine, scene.name, None, observers)?;
        let facts = drive_text::facts(&result, scene.seed);
        let command = format!("inbye drive --scene {} --report out", scene.name);
        Ok(Self { scene, simulation, result, playback, facts, command })
    }

    /// The drive on the report's page.
    fn view<'a>(&'a self, config: &'a Config) -> MissionView<'a> {
        let Self { scene, simulation, result, playback, facts, .. } = self;
        MissionView {
            title: scene.title,
            command: &self.command,
            mission: &simulation.mission,
            config,
            result,
            playback: Some(playback),
            facts,
        }
    }
}
