//! `inbye bench draw`.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail, ensure};
use clap::Args;
use inbye::bench::{DensityRow, QualityRow};
use inbye::experiment::barn::BarnRow;
use inbye::experiment::dynabarn::DynaBarnRow;
use inbye::experiment::missions::MissionRow;
use inbye::experiment::records::{Record, Rows, read_record};
use inbye::experiment::sweep::SweepGroup;
use inbye::experiment::{AblationRow, ClosedLoopRow};
use inbye::report::{BenchReport, bench_files, bench_svg};
use serde_json::{Value, json};

use super::output_file::Output;
use super::{output, report_file};

const TITLE: &str = "inbye: benchmark records";

/// `inbye bench draw`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  inbye bench draw latency.csv --svg latency.svg\n  \
    inbye bench draw barn.csv dynabarn.csv --report records\n\n\
    Nothing is measured. A record is recognised by its columns: latencies, regrets and missions of `bench density`, runs of \
    `bench barn`, `bench dynabarn`, `bench soak` and `bench ablation`, groups of `sweep merge`. One of each kind makes one \
    picture. There is none of `bench movingai`, the grids and `bench paper`, which keeps no record."
)]
pub struct DrawArguments {
    /// The records, CSV.
    #[arg(required = true, value_name = "RECORD.csv")]
    pub records: Vec<PathBuf>,
    /// Draw them into this file, side by side.
    #[arg(long, value_name = "FILE.svg")]
    pub svg: Option<PathBuf>,
    /// Write `index.html` into this folder, and beside it each chart as SVG and its rows as CSV and JSON.
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
}

/// The rows of all records.
#[derive(Default)]
struct Drawn {
    density: Vec<DensityRow>,
    quality: Vec<QualityRow>,
    closed_loop: Vec<ClosedLoopRow>,
    barn: Vec<BarnRow>,
    dynabarn: Vec<DynaBarnRow>,
    soak: Vec<MissionRow>,
    ablation: Vec<AblationRow>,
    sweep: Vec<SweepGroup>,
}

impl Drawn {
    /// Takes rows, of which there must be none of the same kind yet.
    fn take(&mut self, rows: Rows) -> bool {
        fn fill<R>(place: &mut Vec<R>, rows: Vec<R>) -> bool {
            let is_first = place.is_empty();
            *place = rows;
            is_first
        }
        match rows {
            Rows::Density(rows) => fill(&mut self.density, rows),
            Rows::Quality(rows) => fill(&mut self.quality, rows),
            Rows::ClosedLoop(rows) => fill(&mut self.closed_loop, rows),
            Rows::Barn(rows) => fill(&mut self.barn, rows),
            Rows::DynaBarn(rows) => fill(&mut self.dynabarn, rows),
            Rows::Soak(rows) => fill(&mut self.soak, rows),
            Rows::Ablation(rows) => fill(&mut self.ablation, rows),
            Rows::Sweep(rows) => fill(&mut self.sweep, rows),
        }
    }
}

/// Draws records.
pub fn run(arguments: &DrawArguments, json: bool) -> anyhow::Result<bool> {
    ensure!(
        arguments.svg.is_some() || arguments.report.is_some(),
        "bench draw: nothing to write into: add --svg FILE.svg or --report DIR"
    );
    let mut drawn = Drawn::default();
    let mut sources: Vec<String> = Vec::new();
    let mut told: Vec<Value> = Vec::new();
    for path in &arguments.records {
        let Record { rows, settings } = read(path)?;
        let what = rows.what();
        sources.push(source(path, what, &settings));
        told.push(json!({ "file": path, "what": what, "settings": settings }));
        if !drawn.take(rows) {
            let file = path.display();
            bail!("{file}: a second record of {what}: draw it into a picture of its own");
        }
    }
    let picture = Output::create("--svg", arguments.svg.as_deref(), &["svg"])?;
    let report = BenchReport {
        title: TITLE,
        intro: &format!("Drawn from {}.", sources.join("; ")),
        machine: &machines(&arguments.records).join(", "),
        command: &report_file::command_line(),
        density: &drawn.density,
        quality: &drawn.quality,
        closed_loop: &drawn.closed_loop,
        barn: &drawn.barn,
        dynabarn: &drawn.dynabarn,
        soak: &drawn.soak,
        ablation: &drawn.ablation,
        sweep: &drawn.sweep,
        ..BenchReport::default()
    };
    if let Some(picture) = picture {
        picture.write(bench_svg(&report))?;
    }
    if let Some(folder) = &arguments.report {
        report_file::write_files(folder, &bench_files(&report))?;
    }
    if json {
        output::json(&json!({ "records": told }))?;
    } else {
        sources.iter().for_each(output::line);
    }
    Ok(true)
}

fn read(path: &Path) -> anyhow::Result<Record> {
    let file = path.display();
    let bytes = fs::read(path).with_context(|| {
        format!("{file}: cannot be read: name a CSV file that `inbye bench` wrote")
    })?;
    Ok(read_record(&bytes, path)?)
}

/// What a file is, in words.
fn source(path: &Path, what: &str, settings: &[String]) -> String {
    let settings = if settings.is_empty() {
        String::new()
    } else {
        format!(", settings {}", settings.join(" and "))
    };
    format!("{} ({what}{settings})", path.display())
}

/// Records lie in a folder named for the machine: these names, each once.
fn machines(records: &[PathBuf]) -> Vec<String> {
    let folder = |path: &PathBuf| {
        let folder = path.parent()?.file_name()?;
        Some(folder.to_string_lossy().into_owned())
    };
    let mut machines: Vec<String> = records.iter().filter_map(folder).collect();
    machines.sort();
    machines.dedup();
    machines
}
