//! `inbye bench ablation`.

use std::path::PathBuf;

use clap::Args;
use inbye::experiment::missions::{MissionRow, Setup};
use inbye::experiment::{ABLATION_VARIANTS, AblationRow, ablation_rows};
use inbye::report::{AblationReport, ablation_files};
use serde_json::json;

use super::arguments::whole;
use super::missions::{Driving, MissionsArguments, cells, one_core};
use super::soak::share;
use super::{engines, output, report_file, soak_words};

/// `inbye bench ablation`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  inbye bench ablation --missions 1 --longest 10 --threads 1 --report ablation\n\n\
    The same missions by six navigators, each with one part more than the one before: the dynamic window alone, the global path \
    whose nodes are touched one after the other as the paper has it, progress along the path, moving obstacles tracked, \
    paths planned anew, recovery. Missions are those of `bench soak`; on half of them one or two boxes or pillars stand on \
    the way that the map does not show, and leave a way.\n\
    The mean time of a variant is that of its own successes, and of the missions that every variant with any success reached."
)]
pub struct AblationArguments {
    #[command(flatten)]
    pub missions_of: MissionsArguments,
    /// Missions, each driven six times.
    #[arg(long, default_value_t = 100, allow_negative_numbers = true, value_parser = whole::<usize>(1, 1_000_000))]
    pub missions: usize,
    /// Share of missions, 0 to 1, with boxes or pillars on the way that the map does not show.
    #[arg(long, default_value_t = 0.5, allow_negative_numbers = true, value_parser = share)]
    pub unmapped: f64,
    /// Write `ablation.html` into this folder, and beside it its charts as SVG and its rows as CSV and JSON.
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
}

/// Drives the missions with each variant.
pub fn run(arguments: &AblationArguments, json: bool) -> anyhow::Result<bool> {
    if let Some(folder) = &arguments.report {
        report_file::create_folder(folder)?;
    }
    let missions = &arguments.missions_of;
    let (config, sites, rules) = missions.read(arguments.unmapped)?;
    let setups: Vec<Setup> = ABLATION_VARIANTS
        .iter()
        .map(|variant| variant.setup(&config))
        .collect();
    let cells = cells(&setups, &sites, arguments.missions, missions.seed);
    let driving = Driving {
        what: "ablation",
        rules: &rules,
        threads: missions.threads.unwrap_or_else(engines::cores),
        record: missions.record.as_deref(),
    };
    let rows = driving.run(&cells, || Ok(one_core()))?;
    let rows: Vec<&MissionRow> = rows.iter().collect();
    let table = ablation_rows(&rows);
    if let Some(folder) = &arguments.report {
        let maps: Vec<&str> = sites.iter().map(|site| site.name.as_str()).collect();
        let files = ablation_files(&AblationReport {
            machine: &engines::machine(),
            command: &report_file::command_line(),
            maps: &maps,
            rows: &table,
        });
        report_file::write_files(folder, &files)?;
    }
    if json {
        output::json(&json!({ "variants": table, "rows": rows }))?;
    } else {
        words(&table).iter().for_each(output::line);
    }
    Ok(true)
}

fn words(table: &[AblationRow]) -> Vec<String> {
    let mut lines = vec![soak_words::HEADER.to_owned()];
    lines.extend(
        table
            .iter()
            .map(|row| soak_words::tally(&row.title, &row.tally)),
    );
    let shared = table.first().map_or(0, |row| row.shared);
    lines.push(format!(
        "over the {shared} missions that every variant with any success reached:"
    ));
    lines.extend(table.iter().map(|row| {
        let time = row
            .mean_shared_time_s
            .map_or_else(|| "-".to_owned(), |time_s| format!("{time_s:.1} s"));
        format!("  {:30} mean time {time}", row.title)
    }));
    for row in table {
        for (word, count) in &row.tally.faults {
            lines.push(format!("{}: fault {word}: {count}", row.title));
        }
    }
    lines
}
