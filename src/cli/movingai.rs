//! `inbye bench movingai`.

use std::path::{Path, PathBuf};

use anyhow::bail;
use clap::Args;
use inbye::bench::movingai::{
    ALGORITHMS, Algorithm, AlgorithmRow, Bench, Files, Folder, MapRows, Queries, find, longest,
};
use inbye::bench::text_table;
use serde_json::json;

use super::arguments::whole;
use super::files::Output;
use super::machine::wall_clock;
use super::output;

/// Columns of the text tables.
const COLUMNS: &str =
    "name solved total suboptimal illegal median_us p95_us max_us expanded worst_length_ratio";

/// `inbye bench movingai`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  inbye bench movingai --map mine.map --scen mine.map.scen --longest 100\n  \
    inbye bench movingai --folder maps --all --passes 3 --json\n\n\
    Every path is checked on the map alone: moves to the eight neighbours, no corner cutting, and its length against the listed one. \
    Exit status 1: a path of an exact algorithm is not the shortest, or a path is missing, illegal or shorter than listed."
)]
pub struct MovingAiArguments {
    /// The map, MovingAI .map.
    #[arg(long, value_name = "M.map", requires = "scen", required_unless_present = "folder")]
    pub map: Option<PathBuf>,
    /// The map's scenarios.
    #[arg(long, value_name = "M.map.scen", requires = "map")]
    pub scen: Option<PathBuf>,
    /// Instead of a map: all maps in this folder and its subfolders that have scenarios, as X.map.scen or X.scen.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["map", "scen"])]
    pub folder: Option<PathBuf>,
    /// Run every algorithm, including the slow and the greedy ones.
    #[arg(long)]
    pub all: bool,
    /// Number of scenarios of each map, those of the greatest listed length [default: all].
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = whole::<usize>(1, 1_000_000_000))]
    pub longest: Option<usize>,
    /// Passes over the scenarios; the time of a query is its shortest.
    #[arg(long, default_value_t = 1, allow_negative_numbers = true, value_parser = whole::<usize>(1, 1000))]
    pub passes: usize,
    /// Write a row for each map and algorithm into this file, CSV or JSON by its extension.
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
}

/// Compares grid search with published optimal lengths. Returns false when an answer was wrong.
pub fn run(arguments: &MovingAiArguments) -> anyhow::Result<bool> {
    let record = Output::of_rows::<AlgorithmRow>("--record", arguments.record.as_deref())?;
    let Folder { files, skipped } = maps(arguments)?;
    for map in &skipped {
        output::note(format!(
            "warning: {map}: left out: there is neither a .map.scen nor a .scen next to it"
        ));
    }
    let queries = read(&files, arguments.longest)?;
    let mut algorithms = ALGORITHMS.to_vec();
    algorithms.retain(|algorithm| arguments.all || algorithm.usual);
    let (maps, totals) = measure(&queries, &algorithms, arguments.passes)?;
    if output::is_json() && arguments.folder.is_none() {
        output::print_json(&maps.first())?;
    } else {
        let object = json!({ "maps": maps, "algorithms": totals, "skipped": skipped });
        output::result(&object, text(&maps, &totals))?;
    }
    record.write_rows(&maps.iter().flat_map(|map| map.algorithms.clone()).collect::<Vec<_>>())?;
    Ok(totals.iter().all(AlgorithmRow::passed))
}

/// The map of the arguments, or those of their folder.
fn maps(arguments: &MovingAiArguments) -> anyhow::Result<Folder> {
    match (&arguments.folder, &arguments.map, &arguments.scen) {
        (Some(folder), _, _) => Ok(find(folder)?),
        (None, Some(map), Some(scen)) => {
            let name = map.display().to_string();
            let files = vec![Files { name, map: map.clone(), scen: scen.clone() }];
            Ok(Folder { files, skipped: Vec::new() })
        }
        _ => bail!("--map needs --scen: name the scenarios of the map"),
    }
}

/// Reads all files before the measurement, so that a bad file is reported at once.
fn read(files: &[Files], count: Option<usize>) -> anyhow::Result<Vec<Queries>> {
    let one = |files: &Files| {
        let mut queries = files.read()?;
        if let Some(count) = count {
            queries.scenarios = longest(queries.scenarios, count);
        }
        Ok(queries)
    };
    files.iter().map(one).collect()
}

/// Measures with a progress bar; the rows of each map, and those of all together.
fn measure(
    queries: &[Queries],
    algorithms: &[Algorithm],
    passes: usize,
) -> anyhow::Result<(Vec<MapRows>, Vec<AlgorithmRow>)> {
    let scenarios: usize = queries.iter().map(|map| map.scenarios.len()).sum();
    let bar =
        output::progress((scenarios * algorithms.len() * passes) as u64, "searching", "searches");
    let mut bench = Bench::new(algorithms, passes);
    let mut clock = wall_clock();
    let mut rows = Vec::new();
    for map in queries {
        // The last part of the path is short enough for the progress bar.
        let name = Path::new(&map.name).file_name().unwrap_or_default();
        bar.set_message(name.to_string_lossy().into_owned());
        rows.push(bench.measure(map, &mut clock, || bar.inc(1))?);
    }
    bar.finish_and_clear();
    Ok((rows, bench.totals()))
}

/// A table for each map, one for all together where there are several, and the wrong answers.
fn text(maps: &[MapRows], totals: &[AlgorithmRow]) -> Vec<String> {
    let mut lines = Vec::new();
    let mut table = |title: &str, scenarios: usize, rows: &[AlgorithmRow]| {
        lines.push(format!("{title}: {scenarios} scenarios"));
        lines.extend(text_table(rows, COLUMNS));
    };
    for map in maps {
        table(&map.map, map.scenarios, &map.algorithms);
    }
    if maps.len() > 1 {
        let scenarios = maps.iter().map(|map| map.scenarios).sum();
        table(&format!("all {} maps", maps.len()), scenarios, totals);
    }
    let fault = |row: &AlgorithmRow| {
        let first = row.first_fault.as_ref()?;
        Some(format!("WRONG: {}, first at {first}", row.name))
    };
    lines.extend(totals.iter().filter_map(fault));
    lines
}
