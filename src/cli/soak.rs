//! `inbye bench soak`.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use clap::Args;
use inbye::experiment::missions::{
    Comparison, MissionRow, MissionSite, Rules, Setup, compare_digests, drive, spread_evenly,
};
use inbye::experiment::{SOAK_SETUP, SoakSummary};
use inbye::local::{CpuEngine, Engine, EngineChoice, InstructionSet, open_engine};
use inbye::report::{BenchReport, Reel, bench_files};
use inbye::runtime::Observer;
use serde_json::{Value, json};

use super::arguments::{number, whole};
use super::missions::{Cell, Driving, MissionsArguments, cells, one_core};
use super::process::wall_clock;
use super::{engines, output, report_file, soak_words, value_parsers};

const INTRO: &str = "Random missions, simulated in a closed loop; all of a mission is drawn from its map and seed: ends on free ground, \
    and who walks there.";
/// Ticks of a mission that was driven again, a line of JSON each.
const TICKS: &str = "ticks.jsonl";

/// `inbye bench soak`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  inbye bench soak --missions 3 --longest 12 --threads 1 --record soak.csv\n\n\
    Everything of a mission is drawn from its map and seed: ends on free ground in the same connected part, yaws, up to \
    --people moving obstacles. Of four missions with people one has heedless ones, and one has people who appear when the \
    robot is near. Maps take turns.\n\
    A contact is the robot's when the true velocity of the touching part of its footprint towards what it touched is above \
    0.02 m/s, or what it touched stands still; the robot loses a mission by either kind.\n\
    Exit status 1: a contact caused by the robot, an unreached goal without a reason, or a trace that another engine does \
    not repeat to the last bit."
)]
pub struct SoakArguments {
    #[command(flatten)]
    pub missions_of: MissionsArguments,
    /// Missions.
    #[arg(long, default_value_t = 1000, allow_negative_numbers = true, value_parser = whole::<usize>(1, 1_000_000))]
    pub missions: usize,
    /// Share of missions, 0 to 1, with boxes or pillars on the way that the map does not show.
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true, value_parser = share)]
    pub unmapped: f64,
    /// Engine, or gpu:NAME for an adapter whose name contains NAME; a CPU engine has one thread.
    #[arg(long, default_value = "cpu", value_parser = value_parsers::engine())]
    pub engine: EngineChoice,
    /// Drive so many of the missions, evenly spread, again on every other engine, and compare their traces: on all GPU
    /// adapters, or where there is none on the CPU with other instructions.
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true, value_parser = whole::<usize>(0, 1_000_000))]
    pub compare: usize,
    /// In place of all missions, drive the one of this seed again, and write a report page and every tick into --report.
    #[arg(long, value_name = "SEED", requires = "report", allow_negative_numbers = true, value_parser = whole::<u64>(0, u64::MAX))]
    pub replay: Option<u64>,
    /// Write `index.html` into this folder, and beside it its charts as SVG and its rows as CSV and JSON; with --replay the
    /// page of that mission, and its ticks.
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
}

pub(super) fn share(text: &str) -> Result<f64, String> {
    number(text, |share| (0.0..=1.0).contains(&share), "0 to 1")
}

/// Drives the missions. False when the robot caused a contact, a goal was missed without a reason, or engines differ.
pub fn run(arguments: &SoakArguments, json: bool) -> anyhow::Result<bool> {
    let (config, sites, rules) = arguments.missions_of.read(arguments.unmapped)?;
    let setups = [Setup {
        name: SOAK_SETUP.to_owned(),
        config,
    }];
    let missions = &arguments.missions_of;
    let cells = cells(&setups, &sites, arguments.missions, missions.seed);
    if let Some((seed, folder)) = arguments.replay.zip(arguments.report.as_deref()) {
        let Some(cell) = cells.iter().find(|cell| cell.seed == seed) else {
            bail!("--replay {seed}: no mission of these has that seed");
        };
        return replay(cell, &rules, folder, json);
    }
    if let Some(folder) = &arguments.report {
        report_file::create_folder(folder)?;
    }
    let engine = || {
        Ok(open_engine(&arguments.engine, 1)
            .map_err(engines::with_option)?
            .engine)
    };
    let first = engine()?.name();
    let driving = Driving {
        what: "soak",
        rules: &rules,
        threads: missions.threads.unwrap_or_else(engines::cores),
        record: missions.record.as_deref(),
    };
    let rows = driving.run(&cells, engine)?;
    if let Some(folder) = &arguments.report {
        let files = bench_files(&BenchReport {
            title: "inbye: a soak of random missions",
            intro: INTRO,
            machine: &engines::machine(),
            command: &report_file::command_line(),
            soak: &rows,
            ..BenchReport::default()
        });
        report_file::write_files(folder, &files)?;
    }
    let rows: Vec<&MissionRow> = rows.iter().collect();
    let comparisons = compare(arguments.compare, &first, &cells, &rows, &driving)?;
    let summary = SoakSummary::of(&rows, &comparisons);
    if json {
        output::json(&object(&summary, &comparisons, &rows)?)?;
    } else {
        soak_words::summary(&summary, &comparisons, &rows)
            .iter()
            .for_each(output::line);
    }
    Ok(summary.is_sound())
}

/// Drives some of the missions again, on each engine to compare with.
fn compare(
    wanted: usize,
    first: &str,
    cells: &[Cell],
    rows: &[&MissionRow],
    driving: &Driving,
) -> anyhow::Result<Vec<Comparison>> {
    if wanted == 0 {
        return Ok(Vec::new());
    }
    let some = spread_evenly(cells, wanted);
    let mut all = Vec::new();
    for other in others(first)? {
        let again = Driving {
            what: "on another engine",
            record: None,
            ..*driving
        };
        let again = again.run(&some, || other.open())?;
        all.extend(compare_digests(rows, &again));
    }
    Ok(all)
}

/// An engine to compare with.
enum Other {
    /// An adapter of this name.
    Gpu(String),
    /// The CPU on one thread with these instructions.
    Cpu(InstructionSet),
}

impl Other {
    fn open(&self) -> anyhow::Result<Box<dyn Engine>> {
        match self {
            Self::Gpu(name) => Ok(open_engine(&EngineChoice::Gpu(Some(name.clone())), 1)?.engine),
            Self::Cpu(instructions) => {
                Ok(Box::new(CpuEngine::with_instruction_set(*instructions, 1)?))
            }
        }
    }
}

/// Every GPU adapter but the first engine itself; where there is none, the CPU with the fastest instructions that are left.
fn others(first: &str) -> anyhow::Result<Vec<Other>> {
    let adapters: Vec<Other> = engines::all()?
        .iter()
        .filter(|engine| engine.kind() == "gpu" && engine.name() != first)
        .map(|engine| Other::Gpu(engine.name()))
        .collect();
    if !adapters.is_empty() {
        return Ok(adapters);
    }
    let slower = InstructionSet::ALL
        .into_iter()
        .rev()
        .find(|one| one.is_available() && *one != InstructionSet::best());
    Ok(slower.map(Other::Cpu).into_iter().collect())
}

fn object(
    summary: &SoakSummary,
    comparisons: &[Comparison],
    rows: &[&MissionRow],
) -> anyhow::Result<Value> {
    let mut object = serde_json::to_value(summary)?;
    object["sound"] = json!(summary.is_sound());
    object["comparisons"] = json!(comparisons);
    object["rows"] = json!(rows);
    Ok(object)
}

/// Drives one mission again, for people to look at.
fn replay(cell: &Cell, rules: &Rules, folder: &Path, json: bool) -> anyhow::Result<bool> {
    report_file::create_folder(folder)?;
    let (site, setup): (&MissionSite, &Setup) = (cell.site, cell.setup);
    let mut reel = Reel::default();
    let mut observer = Observer {
        clock: &mut wall_clock(),
        on_tick: &mut |moment| reel.take(moment),
    };
    let (row, drawn, result) = drive(site, cell.seed, rules, setup, one_core(), &mut observer)?;
    if let Some(result) = &result {
        let title = format!("{}, seed {}", site.name, cell.seed);
        let command = std::env::args().collect::<Vec<_>>().join(" ");
        let (mission, config) = (&drawn.simulation.mission, &setup.config);
        let page = report_file::drive_page(
            mission,
            config,
            result,
            &reel,
            &title,
            &command,
            report_file::SIMULATED,
        );
        report_file::write(folder, &page)?;
        let file = folder.join(TICKS);
        let place = || format!("--report {}", folder.display());
        let mut out = BufWriter::new(File::create(&file).with_context(place)?);
        for tick in &result.trace.rows {
            serde_json::to_writer(&mut out, tick)?;
            out.write_all(b"\n").with_context(place)?;
        }
        out.flush().with_context(place)?;
    }
    if json {
        output::json(&row)?;
    } else {
        output::line(soak_words::story(&row));
    }
    Ok(row.reason.is_none())
}
