//! `inbye bench faults`.

use std::path::PathBuf;

use anyhow::ensure;
use clap::Args;
use inbye::bench::text_table;
use inbye::experiment::{
    ExperimentError, FaultRow, run_in_order, simulated_fault_names, simulated_faults,
};
use serde_json::json;

use super::arguments::whole;
use super::files::Output;
use super::output;
use super::serial_cases::{CASES, SerialCase};
use super::serial_faults::Roadway;

/// Columns of the text table.
const COLUMNS: &str = "fault place runs stood_s limit_s min_gap_m contacts_robot final_error_m final_yaw_error_rad parking_s passed";

/// `inbye bench faults`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  inbye bench faults --seeds 1 --serial 0 --only lidar\n\n\
    Each fault begins while the robot drives at speed. The robot must stand within the time of its row, or may drive on, and \
    must never cause a contact. `stood` is the longest time from the fault until the robot finally stood still.\n\
    On the serial lines one process emulates a base and its lidar, and another process drives it in real time. The emulated \
    motors lag, and the tracks slip. The faults are those of the base, its line, its lidar and the process that drives. People step \
    out, and the robot is carried away. During three of the faults no command can stop the base: the drive must end with a reason. \
    A mission without a fault must park within 0.02 m and 0.01 rad of its goal. `parking` is the time from the first pose within \
    0.25 m of the goal to the end of the drive; its limit is `limit`.\n\n\
    JSON fields: `rows`, `passed`.\n\
    Exit status 1: a row has not passed.")]
pub struct FaultsArguments {
    /// Drives of each fault in simulation, with consecutive seeds; 0 leaves them out.
    #[arg(long, default_value_t = 4, allow_negative_numbers = true, value_parser = whole::<u64>(0, 1000))]
    pub seeds: u64,
    /// Only the faults in simulation whose name contains this text.
    #[arg(long, value_name = "TEXT", default_value = "", hide_default_value = true)]
    pub only: String,
    /// Drives on emulated serial lines at a time; 0 leaves them out.
    #[arg(long, default_value_t = 4, allow_negative_numbers = true, value_parser = whole::<usize>(0, 64))]
    pub serial: usize,
    /// Write a row for each fault into this file, CSV or JSON by its extension.
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
}

/// Names of the faults in simulation that are requested. That nothing is requested is an error: a check of nothing passes.
fn selected(arguments: &FaultsArguments) -> anyhow::Result<Vec<&'static str>> {
    let FaultsArguments { seeds, ref only, serial, .. } = *arguments;
    ensure!(
        seeds > 0 || serial > 0,
        "--seeds 0 --serial 0: no fault is left: leave one of them out"
    );
    ensure!(
        seeds > 0 || only.is_empty(),
        "--only {only}: --seeds 0 leaves out all faults in simulation: leave one of them out"
    );
    let names = simulated_fault_names().filter(|name| name.contains(only));
    let names: Vec<&str> = if seeds > 0 { names.collect() } else { Vec::new() };
    let example = simulated_fault_names().next().unwrap_or_default();
    ensure!(
        seeds == 0 || !names.is_empty(),
        "--only {only}: no fault in simulation has this text in its name: choose a part of one, such as `{example}`"
    );
    Ok(names)
}

/// Injects every fault. Returns false if a robot did not do what its row requires.
pub fn run(arguments: &FaultsArguments) -> anyhow::Result<bool> {
    let record = Output::of_rows::<FaultRow>("--record", arguments.record.as_deref())?;
    let seeds: Vec<u64> = (1..=arguments.seeds).collect();
    let names = selected(arguments)?;
    let bar = output::progress(names.len() as u64 * arguments.seeds, "faults", "drives");
    let mut rows = simulated_faults(&names, &seeds, || bar.inc(1))?;
    bar.finish_and_clear();
    if arguments.serial > 0 {
        let roadway = Roadway::write()?;
        let bar = output::progress(CASES.len() as u64, "serial lines", "cases");
        let drive = |case: &SerialCase| Ok::<_, ExperimentError>(case.drive(&roadway));
        rows.extend(run_in_order(&CASES, arguments.serial, drive, || bar.inc(1))?);
        bar.finish_and_clear();
    }
    let passed = rows.iter().all(|row| row.passed);
    let failed = rows.iter().filter(|row| !row.passed);
    let reasons = failed.map(|row| {
        format!("FAILED: {} ({}): {}", row.fault, row.place, row.reason.as_deref().unwrap_or("-"))
    });
    let lines = text_table(&rows, COLUMNS).into_iter().chain(reasons);
    output::result(&json!({ "rows": rows, "passed": passed }), lines)?;
    record.write_rows(&rows)?;
    Ok(passed)
}
