//! `inbye bench`.

use std::fs::File;
use std::io::Write;
use std::path::Path;

use anyhow::{Context, bail};
use inbye::bench::{DensityPlan, DensityRow, measure_density};
use inbye::local::Engine;
use serde_json::json;

use super::arguments::DensityArguments;
use super::clock::wall_clock;
use super::{engines, output};

/// Sampling density against latency.
pub fn density(arguments: &DensityArguments, json: bool) -> anyhow::Result<bool> {
    let (least, most) = (arguments.min_samples, arguments.max_samples);
    if least > most {
        bail!(
            "--min-samples {least} is above --max-samples {most}: lower the one or raise the other"
        );
    }
    let plan = DensityPlan::powers_of_four(arguments.steps, least, most, arguments.seconds);
    let table = arguments.record.as_deref().map(Table::create).transpose()?;
    let rows = measure(&mut engines::all()?, &plan)?;
    if let Some(table) = table {
        table.write(&rows)?;
    }
    if json {
        output::json(&json!({ "rows": rows }))?;
        return Ok(true);
    }
    output::line(HEADER);
    for row in &rows {
        output::line(table_row(row));
    }
    Ok(true)
}

/// Measures with a progress bar.
pub fn measure(all: &mut [Box<dyn Engine>], plan: &DensityPlan) -> anyhow::Result<Vec<DensityRow>> {
    let cells = plan.samples.len() * all.len();
    let bar = output::progress(cells as u64, "density");
    let rows = measure_density(all, plan, &mut wall_clock(), |_| bar.inc(1))?;
    bar.finish_and_clear();
    Ok(rows)
}

/// Heads the rows of [`table_row`].
pub const HEADER: &str = "engine                                    samples  steps    p50 ms    p99 ms    max ms   M steps/s";

/// A row for people.
pub fn table_row(row: &DensityRow) -> String {
    let engine = match &row.adapter {
        Some(adapter) => adapter.clone(),
        None if row.threads == 1 => "CPU, 1 thread".to_owned(),
        None => format!("CPU, {} threads", row.threads),
    };
    format!(
        "{engine:40} {:8} {:6} {:9.3} {:9.3} {:9.3} {:11.1}",
        row.samples,
        row.steps,
        row.p50_ms,
        row.p99_ms,
        row.max_ms,
        row.steps_per_s / 1e6,
    )
}

/// The file that the rows go into, opened before they are measured.
struct Table<'a> {
    name: &'a Path,
    file: File,
    text: fn(&[DensityRow]) -> anyhow::Result<String>,
}

impl<'a> Table<'a> {
    fn create(name: &'a Path) -> anyhow::Result<Self> {
        let text: fn(&[DensityRow]) -> anyhow::Result<String> =
            match name.extension().and_then(|ending| ending.to_str()) {
                Some("json") => |rows| Ok(serde_json::to_string_pretty(rows)? + "\n"),
                Some("csv") => |rows| Ok(csv(rows)),
                _ => bail!(
                    "--record {}: the name must end in .csv or .json",
                    name.display()
                ),
            };
        let file = output::create_record(name)?;
        Ok(Self { name, file, text })
    }

    fn write(mut self, rows: &[DensityRow]) -> anyhow::Result<()> {
        let text = (self.text)(rows)?;
        self.file
            .write_all(text.as_bytes())
            .with_context(|| format!("--record {}", self.name.display()))
    }
}

fn csv(rows: &[DensityRow]) -> String {
    const HEADER: &str =
        "engine,adapter,threads,samples,steps,p50_ms,p95_ms,p99_ms,max_ms,decisions,steps_per_s\n";
    let line = |row: &DensityRow| {
        let adapter = row.adapter.as_deref().unwrap_or_default().replace('"', "'");
        format!(
            "{},\"{adapter}\",{},{},{},{},{},{},{},{},{}\n",
            row.engine,
            row.threads,
            row.samples,
            row.steps,
            row.p50_ms,
            row.p95_ms,
            row.p99_ms,
            row.max_ms,
            row.decisions,
            row.steps_per_s,
        )
    };
    let lines: Vec<String> = rows.iter().map(line).collect();
    HEADER.to_owned() + &lines.concat()
}
