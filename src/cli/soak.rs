//! `inbye bench soak`.

use std::path::{Path, PathBuf};

use anyhow::{bail, ensure};
use clap::Args;
use inbye::bench::EngineRequest;
use inbye::experiment::{
    Cell, Comparison, Grid, IdentifiedMotion, RunRow, Setup, Share, SoakSummary, Spread,
    compare_digests, run_cell, spread_evenly,
};
use inbye::local::{CpuEngine, CpuEngines, Engine, EngineChoice, InstructionSet, open_engine};
use inbye::report::BenchReport;
use inbye::runtime::{Config, PlantKind, PoseSource};
use inbye::suggest::counted;
use serde_json::json;

use super::arguments::{decision_size, engine, plants, pose_source, real, whole};
use super::files::{PAGE, ReportFolder, all_written, open_file};
use super::machine::{self, wall_clock};
use super::missions::MissionsArguments;
use super::runs::{group_table, in_memory, run_text, unreached};
use super::{engine_selection, output, recording, run_page};

const INTRO: &str = "Random missions, simulated in a closed loop; map and seed determine a mission: start and goal in free space, \
    and moving obstacles.";
/// Ticks of a mission that was driven again, a line of JSON each.
const TICKS: &str = "ticks.jsonl";

/// `inbye bench soak`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  inbye bench soak --missions 3 --seed 3 --longest 12 --threads 1 --record soak.csv\n\n\
    Map and seed determine a mission: start and goal in connected free space, yaws, up to --people moving obstacles. Of six \
    missions with people, two have people who walk across or along the path and yield. The other four have, one each, people who do \
    not yield, appear, start to walk, or step out of a crossing when the robot is near. Maps take turns.\n\
    On the disagreeing plant, latency, braking, acceleration, slip, slope, noise and the pedestrians' speed (up to 1.6 m/s) \
    and legs are drawn for each mission from [simulation.plant_ranges]; the navigator does not get them. The rows hold the values.\n\
    The robot causes a contact when the true velocity of the touching part of its footprint towards the other body is above \
    0.02 m/s, or when that body stands; a mission with any contact is lost.\n\
    With --out the same command resumes where it was interrupted.\n\
    JSON fields: `summary`, `sound`, `comparisons`, `rows`.\n\
    Exit status 1: a contact caused by the robot, an unreached goal without a reason, or a trace that another engine does \
    not repeat to the last bit."
)]
pub struct SoakArguments {
    #[command(flatten)]
    pub missions_of: MissionsArguments,
    /// Missions.
    #[arg(long, default_value_t = 1000, allow_negative_numbers = true, value_parser = whole::<usize>(1, 1_000_000))]
    pub missions: usize,
    /// True parameters of the simulated robot: those of the settings, or drawn for each mission, or each mission with both.
    #[arg(long, default_value = "disagreeing", value_parser = plants())]
    pub plant: &'static [PlantKind],
    /// Source of the robot's pose [default: the settings'].
    #[arg(long, value_parser = pose_source())]
    pub pose_source: Option<PoseSource>,
    /// Share of missions, 0 to 1, with boxes or pillars on the path that the map does not show.
    #[arg(long, default_value_t = 0.5, allow_negative_numbers = true, value_parser = real(0.0..=1.0, "0 to 1"))]
    pub unmapped: f64,
    /// Engine, or gpu:NAME for an adapter whose name contains NAME; a CPU engine has one thread.
    #[arg(long, default_value = "cpu", value_parser = engine())]
    pub engine: EngineRequest,
    /// Drive this many missions, evenly spread, again on every other engine, and compare their traces: on all GPU adapters,
    /// or without one on the CPU with other instructions.
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true, value_parser = whole::<usize>(0, 1_000_000))]
    pub compare: usize,
    /// Drive only the mission of this seed again, and write a report page and every tick into --report.
    #[arg(long, value_name = "SEED", requires = "report", allow_negative_numbers = true, value_parser = whole::<u64>(0, u64::MAX))]
    pub replay: Option<u64>,
    /// Write `index.html`, its charts as SVG and its rows as CSV and JSON into this folder; with --replay the page of that
    /// mission and its ticks.
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
}

/// The settings of the plants, each with a name if there are two.
fn setups(arguments: &SoakArguments, mut config: Config) -> Vec<Setup> {
    config.pose_source = arguments.pose_source.unwrap_or(config.pose_source);
    let kinds = arguments.plant;
    let of = |&kind: &PlantKind| {
        let mut config = config.clone();
        config.simulation.plant = kind;
        match (kinds.len(), kind) {
            (1, _) => Setup::unnamed(config),
            (_, PlantKind::Agreeing) => Setup::named("agreeing", config),
            _ => Setup::named("disagreeing", config),
        }
    };
    kinds.iter().map(of).collect()
}

/// Drives the missions. False when the robot caused a contact, a goal was missed without a reason, or engines differ.
pub fn run(arguments: &SoakArguments) -> anyhow::Result<bool> {
    let missions = &arguments.missions_of;
    let (config, worlds) = missions.read(arguments.unmapped)?;
    let size = decision_size(&config);
    let setups = setups(arguments, config);
    let grid = Grid::of_missions("soak", &worlds, &setups, arguments.missions, missions.seed)?;
    if let Some((seed, folder)) = arguments.replay.zip(arguments.report.as_deref()) {
        ensure!(
            arguments.plant.len() == 1,
            "--replay {seed}: two missions have that seed: give --plant agreeing or disagreeing"
        );
        let Some(cell) = grid.cells.iter().find(|cell| cell.row.seed == seed) else {
            bail!("--replay {seed}: no mission of these has that seed");
        };
        return replay(cell, folder);
    }
    let report = ReportFolder::create(arguments.report.as_deref())?;
    let first = engine_selection::open(&arguments.engine, &size, 1)?;
    let grid = match first.kind() {
        "gpu" => grid.on_engine(&format!("gpu:{}", first.name())),
        _ => grid,
    };
    let (rows, recorded) = missions.drive(&grid)?;
    let comparisons = compare(arguments, &first.name(), &grid, &rows)?;
    let summary = SoakSummary::of(&rows, &comparisons);
    let is_sound = summary.is_sound();
    let object =
        json!({ "summary": summary, "sound": is_sound, "comparisons": comparisons, "rows": rows });
    let lines = text(&summary, &comparisons).into_iter();
    output::result(&object, lines.chain(unreached(&rows)))?;
    let reported = report.write_bench(BenchReport {
        title: "inbye: a soak of random missions",
        intro: INTRO,
        soak: &rows,
        ..BenchReport::default()
    });
    all_written([recorded, reported])?;
    Ok(is_sound)
}

/// Drives some of the missions again on each engine to compare with.
fn compare(
    arguments: &SoakArguments,
    first: &str,
    grid: &Grid,
    rows: &[RunRow],
) -> anyhow::Result<Vec<Comparison>> {
    if arguments.compare == 0 {
        return Ok(Vec::new());
    }
    let some = Grid {
        title: "on another engine".to_owned(),
        cells: spread_evenly(&grid.cells, arguments.compare),
    };
    let (jobs, machine) = (arguments.missions_of.run.jobs(), machine::description());
    let mut all = Vec::new();
    for open in others(first)? {
        let run = |cell: &&Cell| Ok(run_cell(cell, open()?, &mut wall_clock(), &machine)?);
        let again = in_memory(&some, jobs, run)?;
        all.extend(compare_digests(rows, &again));
    }
    Ok(all)
}

/// Opens an engine to compare with.
type Open = Box<dyn Fn() -> anyhow::Result<Box<dyn Engine>> + Sync>;

/// Every GPU adapter except the first engine; without one the CPU on one thread with the next slower instructions.
fn others(first: &str) -> anyhow::Result<Vec<Open>> {
    let engines = machine::engines(CpuEngines::OneAndAll)?.open;
    let adapters = engines.iter().filter(|engine| engine.kind() == "gpu" && engine.name() != first);
    let open =
        |choice: EngineChoice| -> Open { Box::new(move || Ok(open_engine(&choice, 1)?.engine)) };
    let adapters: Vec<Open> =
        adapters.map(|engine| open(EngineChoice::Gpu(Some(engine.name())))).collect();
    if !adapters.is_empty() {
        return Ok(adapters);
    }
    let slower = InstructionSet::ALL
        .into_iter()
        .rev()
        .find(|one| one.is_available() && *one != InstructionSet::best());
    let cpu =
        |set| -> Open { Box::new(move || Ok(Box::new(CpuEngine::with_instruction_set(set, 1)?))) };
    Ok(slower.map(cpu).into_iter().collect())
}

/// Tables of all missions, by map and by traffic, and the comparisons.
fn text(summary: &SoakSummary, comparisons: &[Comparison]) -> Vec<String> {
    let mut groups = vec![summary.all.clone()];
    let plants = if summary.plants.len() > 1 { &summary.plants[..] } else { &[] };
    groups.extend(plants.iter().chain(&summary.worlds).chain(&summary.traffic).cloned());
    let mut lines = group_table(&groups);
    lines.extend(
        [
            ("reached", &summary.reached),
            ("contacts by the robot", &summary.contacts_robot),
            ("contacts by people who do not yield", &summary.contacts_of_non_yielding),
        ]
        .map(|(name, share)| share_text(name, share)),
    );
    lines.extend(summary.faults.iter().map(|(name, count)| format!("fault {name}: {count}")));
    if let Some(speed) = summary.mean_speed_m_s {
        let (km, hours) = (summary.travelled_m / 1e3, summary.time_s / 3600.0);
        lines.push(format!(
            "mean speed   {speed:.2} m/s of the missions that arrived; all drove {km:.1} km in {hours:.1} h"
        ));
    }
    if let Some(error) = summary.final_error {
        lines.push(format!(
            "final error  mean {:.4} m and {:.4} rad, p95 {:.4} m and {:.4} rad",
            error.mean_m, error.mean_yaw_rad, error.p95_m, error.p95_yaw_rad
        ));
    }
    lines.push(format!(
        "protection   acted in {}, in {:.1} % of all ticks",
        counted(summary.protected_missions, "mission"),
        100.0 * summary.protected_share
    ));
    lines.extend(summary.identified.as_ref().map(identified_text));
    if summary.digests_compared > 0 {
        let (equal, compared) = (summary.digests_equal, summary.digests_compared);
        lines.push(format!("traces       {equal} of {compared} equal on another engine"));
    }
    let text = |text: &Option<String>| text.clone().unwrap_or_else(|| "none".to_owned());
    let different = comparisons.iter().filter(|one| !one.equal);
    lines.extend(different.map(|one| {
        let (first, expected) = (text(&one.first), text(&one.expected));
        let (engine, found) = (text(&one.engine), text(&one.found));
        let (world, seed) = (&one.world, one.seed);
        format!("DIFFERS: {world}, seed {seed}: {first} gave {expected}, {engine} gave {found}")
    }));
    lines
}

/// The identified response of the bases.
fn identified_text(identified: &IdentifiedMotion) -> String {
    let spread = |Spread { least, mean, largest, .. }: &Spread, unit: &str| {
        format!("{least:.2} to {largest:.2}{unit}, mean {mean:.2}{unit}")
    };
    let turn = identified.turn_ratio.as_ref();
    let turn = turn.map_or_else(String::new, |ratio| format!("; turn ratio {}", spread(ratio, "")));
    format!(
        "identified   latency in {}, {}, below the drawn delay in {}; braking {}{turn}",
        counted(identified.missions, "mission"),
        spread(&identified.delay_s, " s"),
        identified.underestimated_delays,
        spread(&identified.braking_m_s2, " m/s^2"),
    )
}

/// A share with its interval.
fn share_text(name: &str, share: &Share) -> String {
    let Share { count, of, interval_95: [low, high], .. } = share;
    if *of == 0 {
        return format!("{name}: no mission of this kind");
    }
    format!(
        "{name}: {count} of {}, 95 % interval {:.1} to {:.1} %",
        counted(*of, "mission"),
        low * 100.0,
        high * 100.0
    )
}

/// Drives one mission again with a page and its ticks.
fn replay(cell: &Cell, folder: &Path) -> anyhow::Result<bool> {
    ReportFolder::create(Some(folder))?;
    let run = run_page::write(cell, cell.row.config.as_deref(), "--report", &folder.join(PAGE))?;
    output::note(format!("report: {}", folder.join(PAGE).display()));
    if let Some(result) = &run.result {
        recording::write_ticks("--report", open_file("--report", &folder.join(TICKS))?, result)?;
    }
    output::result(&run.row, [run_text(&run.row)])?;
    Ok(run.row.reached())
}
