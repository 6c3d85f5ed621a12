//! Cells: their files and the list of them.

use std::path::Path;
use std::sync::Arc;

use crate::support::room;
use inbye::digest::BitDigest;
use inbye::experiment::{
    Cell, CellFile, Grid, LocalizationCase, LocalizationSite, Manifest, RunOutcome, RunRow, Setup,
    World, localization_config, open_engine, run_cell,
};
use inbye::geometry::{Point, Pose};
use inbye::local::SharedEngines;
use inbye::map::OccupancyGrid;

/// A grid of one drive among people in a room that is too small for them.
fn crowded() -> Grid {
    let rows = room::rows(30, 20, &[]);
    let map = OccupancyGrid::from_rows(&rows, 0.2, Pose::default()).expect("a map");
    let site = Arc::new(LocalizationSite {
        name: "room".to_owned(),
        map: Arc::new(map),
        start: Pose::new(1.5, 2.0, 0.0),
        goal: Point::new(4.0, 2.0),
        tour_m: 10.0,
    });
    let worlds = [World::localization(LocalizationCase::People, &site)];
    let setups = [Setup::unnamed(localization_config())];
    Grid::of_worlds("crowded", &worlds, &setups, &[7]).expect("its settings are pure")
}

fn run(cell: &Cell) -> CellFile {
    run_cell(
        cell,
        open_engine(cell, &SharedEngines::default()).expect("the CPU"),
        &mut || 0.0,
        "machine",
    )
    .expect("the CPU does not fail")
}

/// The text of a cell's file with this line and its digest.
fn signed(line: &str) -> String {
    let mut digest = BitDigest::default();
    digest.text(line);
    format!("{line}\n{}\n", digest.hex())
}

#[test]
fn run_that_cannot_start_is_a_row_with_its_case_and_its_reason() {
    let grid = crowded();
    let row = run(&grid.cells[0]).row;
    assert_eq!(row.outcome, RunOutcome::Error, "{row:#?}");
    assert_eq!((row.case, row.ticks), (Some(LocalizationCase::People), 0));
    assert!(row.reason.is_some_and(|reason| reason.contains("moving obstacles")));
    assert_eq!(row.key, grid.cells[0].row.key);
}

#[test]
fn cell_file_is_read_in_any_order_of_its_inputs() {
    let cell = &crowded().cells[0];
    let file = run(cell);
    let (text, path) = (file.text(), Path::new("cell.json"));
    let line = text.lines().next().expect("a line");
    let read = |line: &str| CellFile::parse(signed(line).as_bytes(), path, &cell.row.key);
    assert_eq!(read(line).as_ref(), Ok(&file));
    let inputs = r#""engine":"cpu","format":7,"#;
    let reordered = line.replacen(inputs, r#""format":7,"engine":"cpu","#, 1);
    assert_ne!(reordered, line);
    assert_eq!(read(&reordered).as_ref(), Ok(&file));
    // The order of a list counts.
    let mut swapped = file;
    let discs = swapped.inputs["settings"]["robot"]["footprint"].as_array_mut();
    discs.expect("a list").reverse();
    let text = swapped.text();
    let error = read(text.lines().next().expect("a line")).expect_err("it is another cell");
    assert!(error.to_string().contains("another cell"), "{error}");
}

#[test]
fn manifest_refuses_a_malformed_key() {
    let (manifest, path) = (Manifest::of(&crowded()), Path::new("sweep.json"));
    let key = manifest.cells[0].key.clone();
    let read = |key: &str| {
        let mut manifest = manifest.clone();
        manifest.cells[0].key = key.to_owned();
        Manifest::parse(manifest.text().as_bytes(), path)
    };
    assert_eq!(read(&key).expect("a digest").keys(), [key.as_str()]);
    for malformed in ["", "../../elsewhere", &key[1..], &key.replace(&key[..1], "g")] {
        let error = read(malformed).expect_err(malformed).to_string();
        assert!(error.contains("cells[0].key") && error.contains("name a folder"), "{error}");
    }
    let without_key = manifest.text().replace(&format!("\"key\":\"{key}\""), "\"seed\":7");
    assert!(Manifest::parse(without_key.as_bytes(), path).is_err(), "{without_key}");
}

/// Otherwise the fuzzer would start with files that the check of the version refuses.
#[test]
fn fuzz_corpus_has_sweep_files_of_this_version() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus/sweep_files");
    let read = |name| std::fs::read(folder.join(name)).expect("it is committed");
    let manifest = Manifest::parse(&read("sweep.json"), Path::new("sweep.json")).expect("a list");
    assert_ne!(manifest.keys(), [""; 0]);
    let cell = read("cell.json");
    let text = str::from_utf8(&cell).expect("text");
    let line = text.lines().next().expect("a line");
    let RunRow { key, .. } = serde_json::from_str::<CellFile>(line).expect("a cell").row;
    let file = CellFile::parse(&cell, Path::new("cell.json"), &key).expect("a cell");
    assert_eq!(file.text(), text);
}
