//! Compares two settings on the same worlds with the same seeds: `cargo run --release --features experiment --example experiment`

#![expect(clippy::print_stdout, reason = "an example prints its result")]

use std::error::Error;
use std::path::Path;

use inbye::bench::text_table;
use inbye::experiment::{Grid, Group, Plan, groups, run_cell};
use inbye::local::CpuEngine;
use inbye::runtime::parse_toml;

/// The text of a plan, as `inbye sweep` reads it from a file. `inbye sweep --print-plan` prints every key.
const PLAN: &str = r#"
seeds = [0, 1]
[configs.usual]
[configs.careful]
navigator.safety_margin_m = 0.15
[[worlds]]
kind = "missions"
longest_m = 10.0
people = 1
"#;

fn main() -> Result<(), Box<dyn Error>> {
    let plan = parse_toml(PLAN, &Plan::default(), Plan::check)?;
    // Paths of maps in the plan are relative to this folder.
    let grid = Grid::new(&plan, Path::new(""))?;
    let mut rows = Vec::new();
    for cell in grid.distinct() {
        // A cell that does not start has a row with the reason.
        let engine: Box<dyn inbye::local::Engine> = Box::new(CpuEngine::single_threaded());
        rows.push(run_cell(cell, engine, &mut || 0.0, "this machine")?.row);
    }
    text_table(&groups(&rows), Group::SUMMARY).iter().for_each(|line| println!("{line}"));
    Ok(())
}
