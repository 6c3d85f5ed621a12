//! `inbye bench movingai`.

use std::path::Path;

use anyhow::bail;
use inbye::bench::movingai::{
    ALGORITHMS, Algorithm, AlgorithmRow, Bench, Files, Folder, MapRows, Queries, find, longest,
};
use inbye::bench::text_table;
use serde_json::json;

use super::arguments::MovingAiArguments;
use super::output_file::Output;
use super::process::wall_clock;
use super::{output, output_file};

/// Compares grid search with published optimal lengths. False when an answer was wrong.
pub fn run(arguments: &MovingAiArguments, json: bool) -> anyhow::Result<bool> {
    let record = Output::create("--record", arguments.record.as_deref(), &["csv", "json"])?;
    let Folder { files, skipped } = maps(arguments)?;
    for map in &skipped {
        output::note(format!(
            "warning: {map}: left out: there is neither a .map.scen nor a .scen next to it"
        ));
    }
    let queries = read(&files, arguments.longest)?;
    let usual = |algorithm: &Algorithm| arguments.all || algorithm.usual;
    let algorithms: Vec<Algorithm> = ALGORITHMS.into_iter().filter(usual).collect();
    let (maps, totals) = measure(&queries, &algorithms, arguments.passes)?;
    if let Some(record) = record {
        let rows: Vec<AlgorithmRow> = maps.iter().flat_map(|map| map.algorithms.clone()).collect();
        output_file::write_rows(record, &rows)?;
    }
    if json && arguments.folder.is_none() {
        output::json(&maps.first())?;
    } else if json {
        output::json(&json!({ "maps": maps, "algorithms": totals, "skipped": skipped }))?;
    } else {
        text(&maps, &totals).iter().for_each(output::line);
    }
    Ok(totals.iter().all(AlgorithmRow::passed))
}

/// The map of the arguments, or those of their folder.
fn maps(arguments: &MovingAiArguments) -> anyhow::Result<Folder> {
    match (&arguments.folder, &arguments.map, &arguments.scen) {
        (Some(folder), _, _) => Ok(find(folder)?),
        (None, Some(map), Some(scen)) => Ok(Folder {
            files: vec![Files {
                name: map.display().to_string(),
                map: map.clone(),
                scen: scen.clone(),
            }],
            skipped: Vec::new(),
        }),
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
    let bar = output::progress((scenarios * algorithms.len() * passes) as u64, "");
    let mut bench = Bench::new(algorithms, passes);
    let mut clock = wall_clock();
    let mut rows = Vec::new();
    for map in queries {
        bar.set_message(file_name(&map.name));
        rows.push(bench.measure(map, &mut clock, || bar.inc(1))?);
    }
    bar.finish_and_clear();
    Ok((rows, bench.totals()))
}

/// The last part of a path, short enough for the progress bar.
fn file_name(path: &str) -> String {
    let name = Path::new(path).file_name().unwrap_or_default();
    name.to_string_lossy().into_owned()
}

/// Columns of the text tables.
const COLUMNS: [&str; 10] = [
    "name",
    "solved",
    "total",
    "suboptimal",
    "illegal",
    "median_us",
    "p95_us",
    "max_us",
    "expanded",
    "worst_length_ratio",
];

/// A table for each map, one for all together where there are several, and the wrong answers.
fn text(maps: &[MapRows], totals: &[AlgorithmRow]) -> Vec<String> {
    let mut lines = Vec::new();
    let mut table = |title: &str, scenarios: usize, rows: &[AlgorithmRow]| {
        lines.push(format!("{title}: {scenarios} scenarios"));
        lines.extend(text_table(rows, &COLUMNS));
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
