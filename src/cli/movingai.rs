//! `inbye bench movingai`.

use std::path::Path;

use anyhow::bail;
use inbye::bench::movingai::{
    ALGORITHMS, Algorithm, AlgorithmRow, Bench, Files, Folder, MapRows, Queries, find, longest,
};
use serde_json::json;

use super::arguments::MovingAiArguments;
use super::output_file::Output;
use super::process::wall_clock;
use super::record_file::{self, MapAlgorithm};
use super::{movingai_words, output};

/// Grid search against published optimal lengths. False: an answer was wrong.
pub fn run(arguments: &MovingAiArguments, json: bool) -> anyhow::Result<bool> {
    let record = Output::create("--record", arguments.record.as_deref(), &["csv", "json"])?;
    let Folder { files, skipped } = maps(arguments)?;
    for map in &skipped {
        output::note(format!(
            "warning: {map}: left out, since there is neither a .map.scen nor a .scen beside it"
        ));
    }
    let queries = read(&files, arguments.longest)?;
    let usual = |algorithm: &Algorithm| arguments.all || algorithm.usual;
    let algorithms: Vec<Algorithm> = ALGORITHMS.into_iter().filter(usual).collect();
    let (maps, totals) = measure(&queries, &algorithms, arguments.passes)?;
    if let Some(record) = record {
        record_file::write(record, &record_rows(&maps))?;
    }
    if json && arguments.folder.is_none() {
        output::json(&maps.first())?;
    } else if json {
        output::json(&json!({ "maps": maps, "algorithms": totals, "skipped": skipped }))?;
    } else {
        movingai_words::tables(&maps, &totals)
            .iter()
            .for_each(output::line);
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

/// Reads all files before anything is measured, so that a bad one is told at once.
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

/// Measures with a progress bar: each map, and all together.
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

/// The last part of a path, which has room beside the progress bar.
fn file_name(path: &str) -> String {
    let name = Path::new(path).file_name().unwrap_or_default();
    name.to_string_lossy().into_owned()
}

/// A row for each map and algorithm.
fn record_rows(maps: &[MapRows]) -> Vec<MapAlgorithm> {
    let mut rows = Vec::new();
    for map in maps {
        rows.extend(map.algorithms.iter().map(|row| MapAlgorithm {
            map: map.map.clone(),
            row: row.clone(),
        }));
    }
    rows
}
