//! `inbye bench draw`.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail, ensure};
use clap::Args;
use inbye::experiment::{Record, RunRow, read_record};
use inbye::input_file::read_bytes;
use inbye::report::{BenchReport, bench_files, bench_svg};
use serde_json::json;

use super::files::{Output, ReportFolder, all_written, command_line};
use super::output;

/// Largest record, bytes: a million rows.
const MAX_RECORD_BYTES: u64 = 1 << 28;

const TITLE: &str = "inbye: benchmark records";

/// `inbye bench draw`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  inbye bench draw latency.csv --svg latency.svg\n  \
    inbye bench draw barn.csv dynabarn.csv --report records\n\n\
    Nothing is measured. The columns identify what a record contains: latencies, regrets and missions of `bench density`, runs of \
    `bench barn`, `bench dynabarn`, `bench soak` and `bench ablation`, tables of `sweep merge`. A picture shows at most one \
    record of each kind. Records of `bench movingai` cannot be drawn.")]
pub struct DrawArguments {
    /// The records, CSV.
    #[arg(required = true, value_name = "RECORD.csv")]
    pub records: Vec<PathBuf>,
    /// Draw them into this file, side by side.
    #[arg(long, value_name = "FILE.svg")]
    pub svg: Option<PathBuf>,
    /// Write `index.html` into this folder, with each chart as SVG and its rows as CSV and JSON.
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
}

/// Adds the rows of a record to a report. Returns false when the report has rows of this kind already.
fn add<'r>(report: &mut BenchReport<'r>, record: &'r Record) -> bool {
    fn fill<'r, R>(place: &mut &'r [R], rows: &'r [R]) -> bool {
        let is_first = place.is_empty();
        *place = rows;
        is_first
    }
    match record {
        Record::Density(rows) => fill(&mut report.density, rows),
        Record::Quality(rows) => fill(&mut report.quality, rows),
        Record::ClosedLoop(rows) => fill(&mut report.closed_loop, rows),
        Record::Barn(rows) => fill(&mut report.barn, rows),
        Record::DynaBarn(rows) => fill(&mut report.dynabarn, rows),
        Record::Soak(rows) => fill(&mut report.soak, rows),
        Record::Ablation(rows) => fill(&mut report.ablation, rows),
        Record::Sweep(rows) => fill(&mut report.sweep, rows),
    }
}

/// Draws records.
pub fn run(arguments: &DrawArguments) -> anyhow::Result<bool> {
    ensure!(
        arguments.svg.is_some() || arguments.report.is_some(),
        "bench draw: nothing to write into: add --svg FILE.svg or --report DIR"
    );
    let paths = &arguments.records;
    let records: Vec<Record> = paths.iter().map(|path| read(path)).collect::<Result<_, _>>()?;
    let named = || paths.iter().zip(&records);
    let sources: Vec<String> =
        named().map(|(path, record)| format!("{} ({})", path.display(), record.title())).collect();
    let machines: Vec<&str> = machines(&records).into_iter().collect();
    let mut report = BenchReport {
        title: TITLE,
        intro: &format!("Drawn from {}.", sources.join("; ")),
        machine: &machines.join(", "),
        command: &command_line(),
        ..BenchReport::default()
    };
    for (path, record) in named() {
        if !add(&mut report, record) {
            let (file, title) = (path.display(), record.title());
            bail!("{file}: a second record of {title}: draw it into a picture of its own");
        }
    }
    let svg = Output::create("--svg", arguments.svg.as_deref(), &["svg"])?;
    let folder = ReportFolder::create(arguments.report.as_deref())?;
    let records = named()
        .map(|(path, record)| json!({ "file": path.to_string_lossy(), "title": record.title() }));
    let object = json!({ "records": records.collect::<Vec<_>>() });
    output::result(&object, &sources)?;
    all_written([svg.write(|| bench_svg(&report)), folder.write(|| bench_files(&report))])?;
    Ok(true)
}

fn read(path: &Path) -> anyhow::Result<Record> {
    let bytes = read_bytes(path, MAX_RECORD_BYTES).with_context(|| path.display().to_string())?;
    Ok(read_record(&bytes, path)?)
}

/// The machines that the rows of the records name.
fn machines(records: &[Record]) -> BTreeSet<&str> {
    let rows = records.iter().flat_map(|record| match record {
        Record::Barn(rows) | Record::DynaBarn(rows) | Record::Soak(rows) => rows.as_slice(),
        _ => &[],
    });
    rows.filter_map(|row: &RunRow| row.machine.as_deref()).collect()
}
