//! `inbye bench ablation`.

use std::path::PathBuf;

use clap::Args;
use inbye::experiment::{ABLATION_VARIANTS, Grid, Setup, ablation_groups, faults};
use inbye::report::{BenchReport, bench_files};
use serde_json::json;

use super::arguments::whole;
use super::missions::{MissionsArguments, share};
use super::run_text::group_table;
use super::{engines, output, report_file};

/// `inbye bench ablation`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  inbye bench ablation --missions 1 --longest 10 --threads 1 --report ablation\n\n\
    The same missions with seven navigators, each with one feature more than the one before: the dynamic window alone, the \
    global path with nodes touched in order as in the paper, progress along the path, tracking of moving obstacles, \
    replanning, passive safety, recovery. Missions are those of `bench soak`; on half of them the map does not show one or \
    two boxes or pillars on the path, which leave a way around.\n\
    The mean time of a variant is that of its own successes; the shared mean time that of the missions that every variant \
    with any success reached.\n\
    JSON fields: `variants`, `rows`."
)]
pub struct AblationArguments {
    #[command(flatten)]
    pub missions_of: MissionsArguments,
    /// Missions, each driven with every variant.
    #[arg(long, default_value_t = 100, allow_negative_numbers = true, value_parser = whole::<usize>(1, 1_000_000))]
    pub missions: usize,
    /// Share of missions, 0 to 1, with boxes or pillars on the path that the map does not show.
    #[arg(long, default_value_t = 0.5, allow_negative_numbers = true, value_parser = share)]
    pub unmapped: f64,
    /// Write `index.html`, its charts as SVG and its rows as CSV and JSON into this folder.
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
}

/// Drives the missions with each variant.
pub fn run(arguments: &AblationArguments, json: bool) -> anyhow::Result<bool> {
    if let Some(folder) = &arguments.report {
        report_file::create_folder(folder)?;
    }
    let missions = &arguments.missions_of;
    let (config, worlds) = missions.read(arguments.unmapped)?;
    let variants = ABLATION_VARIANTS.iter();
    let setups: Vec<Setup> = variants.map(|variant| variant.setup(&config)).collect();
    let count = arguments.missions;
    let grid = Grid::of_missions("ablation", &worlds, &setups, count, missions.seed)?;
    let rows = missions.drive(&grid)?;
    let table = ablation_groups(&rows);
    if let Some(folder) = &arguments.report {
        let maps: Vec<&str> = worlds.iter().map(|world| world.name.as_str()).collect();
        let intro = format!(
            "{count} random missions in simulation, each driven by every variant of the navigator. A variant has one part more \
             than the one before it. Moving obstacles cross the path; on some missions, obstacles that the map does not show \
             stand on it. Maps: {}.",
            maps.join(", ")
        );
        let files = bench_files(&BenchReport {
            title: "inbye: effect of each part of the navigator",
            intro: &intro,
            machine: &engines::machine(),
            command: &report_file::command_line(),
            ablation: &table,
            ..BenchReport::default()
        });
        report_file::write_files(folder, &files)?;
    }
    if json {
        output::json(&json!({ "variants": table, "rows": rows }))?;
        return Ok(true);
    }
    group_table(&table).iter().for_each(output::line);
    let shared = table.first().map_or(0, |row| row.shared);
    output::line(format!(
        "over the {shared} missions that every variant with any success reached:"
    ));
    for row in &table {
        let time_s = row.mean_shared_time_s;
        let time = time_s.map_or_else(|| "-".to_owned(), |time_s| format!("{time_s:.1} s"));
        output::line(format!("  {:30} mean time {time}", row.name));
    }
    for (name, count) in faults(&rows) {
        output::line(format!("fault {name}: {count}"));
    }
    Ok(true)
}
