//! Merged tables, and folders that a merge rejects.

use std::path::Path;

use inbye::experiment::CellFile;
#[cfg(feature = "parquet")]
use parquet::file::reader::{FileReader, SerializedFileReader};
#[cfg(feature = "parquet")]
use parquet::record::Field;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde_json::Value;

use super::Test;
use super::plan_folder::{CELLS, PLAN, PlanFolder};

pub const TESTS: &[Test] = &[
    ("merge rejects a cell file with a changed bit", changed_bits),
    ("merge names a missing cell and keeps the others", missing),
    ("a folder rejects another plan or version", mixtures),
    ("merge rejects a cell with different results", differing),
    ("every number is read from its file to the last bit", numbers),
    #[cfg(feature = "parquet")]
    ("the Parquet table is the CSV table", parquet_is_csv),
    #[cfg(not(feature = "parquet"))]
    ("a build without Parquet says so", missing_parquet_feature_is_named),
    ("the page is drawn from the file of groups", drawn_again),
];

/// A folder with all results in `out`, and one of its cells.
fn done() -> (PlanFolder, String) {
    let place = PlanFolder::done();
    let key = place.finished("out").into_iter().min().expect("a cell");
    (place, key)
}

fn changed_bits() {
    let (place, key) = done();
    let file = format!("out/cells/{key}.json");
    let whole = place.read(&file);
    // The first byte, the last one, and a byte of a number.
    let text = String::from_utf8(whole.clone()).expect("text");
    let time = text.find("time_s\":").expect("a time") + 8;
    for place_of in [0, time, whole.len() / 2, whole.len() - 30, whole.len() - 1] {
        let mut changed = whole.clone();
        changed[place_of] ^= 1;
        place.write(&file, changed);
        for command in ["sweep merge out --report merged", "sweep plan.toml --out out"] {
            let message = place.refusal(command);
            assert!(
                message.contains(&file) && message.contains("delete it"),
                "{place_of}: {message}"
            );
        }
    }
    for torn in [0, 1, whole.len() - 1] {
        place.write(&file, &whole[..torn]);
        assert!(place.refusal("sweep merge out").contains(&file));
    }
    // A valid file under another name.
    place.write(&file, place.read(&format!("out/cells/{}.json", other(&place, &key))));
    assert!(place.refusal("sweep merge out").contains("another cell"));
    place.write(&file, whole);
    place.json("sweep merge out --report merged");
}

fn other(place: &PlanFolder, key: &str) -> String {
    let mut keys = place.finished("out").into_iter();
    keys.find(|other| other != key).expect("a second cell")
}

fn missing() {
    let (place, key) = done();
    std::fs::remove_file(place.path(&format!("out/cells/{key}.json"))).expect("it is there");
    let ran = place.run("sweep merge out --report merged --json");
    assert_eq!(ran.status, 1, "{ran:?}");
    let report: Value = serde_json::from_str(&ran.stdout).expect("JSON");
    assert_eq!(report["missing"], serde_json::json!([key]));
    let table = String::from_utf8(place.read("merged/sweep.csv")).expect("text");
    assert_eq!(table.lines().count(), CELLS, "the header and all rows but one");
    let again = place.json("sweep plan.toml --out out");
    assert_eq!(again["driven"], 1, "{again}");
    place.assert_same_table("out");
}

fn mixtures() {
    let (place, _) = done();
    place.write("other.toml", PLAN.replace("posts", "more posts").replace("[0, 1, 2]", "[0]"));
    place.json("sweep other.toml --out other");
    let message = place.refusal("sweep merge out other");
    for part in ["out and other", "`posts`, 24 cells", "`more posts`, 8 cells"] {
        assert!(message.contains(part), "{part}: {message}");
    }
    let manifest = String::from_utf8(place.read("out/sweep.json")).expect("text");
    let version = format!("\"version\":\"{}\"", env!("CARGO_PKG_VERSION"));
    place.write("out/sweep.json", manifest.replace(&version, "\"version\":\"0.0.7\""));
    assert!(place.refusal("sweep merge out").contains("written by inbye 0.0.7"));
    place.write("out/sweep.json", "{}");
    assert!(place.refusal("sweep merge out").contains("out/sweep.json"));
}

fn differing() {
    let (place, key) = done();
    let file = format!("out/cells/{key}.json");
    let bytes = place.read(&file);
    let mut cell = CellFile::parse(&bytes, Path::new(&file), &key).expect("a cell");
    cell.row.time_s += 0.05;
    place.write(&format!("copy/cells/{key}.json"), cell.text());
    place.write("copy/sweep.json", place.read("out/sweep.json"));
    let message = place.refusal("sweep merge out copy");
    assert!(message.contains(&key) && message.contains("one of the machines errs"), "{message}");
}

fn numbers() {
    let (place, key) = done();
    let file = format!("out/cells/{key}.json");
    let path = Path::new(&file);
    let mut cell = CellFile::parse(&place.read(&file), path, &key).expect("a cell");
    let mut rng = Pcg64Mcg::seed_from_u64(3);
    for _ in 0..20_000 {
        let number = f64::from_bits(rng.random());
        cell.row.time_s = if number.is_finite() { number } else { 0.1 };
        cell.row.travelled_m = rng.random();
        let read = CellFile::parse(cell.text().as_bytes(), path, &key).expect("as it was written");
        assert_eq!(read, cell);
    }
}

#[cfg(not(feature = "parquet"))]
fn missing_parquet_feature_is_named() {
    let (place, _) = done();
    let run = place.run("sweep merge out --report merged");
    assert!(run.stderr.contains("sweep.parquet: not written"), "{run:?}");
    assert!(run.stderr.contains("feature `parquet`"), "{run:?}");
}

#[cfg(feature = "parquet")]
fn parquet_is_csv() {
    let (place, _) = done();
    place.json("sweep merge out --report merged");
    let mut csv = csv::Reader::from_reader(std::io::Cursor::new(place.read("merged/sweep.csv")));
    let header = csv.headers().expect("a header").clone();
    let file = std::fs::File::open(place.path("merged/sweep.parquet")).expect("a file");
    let reader = SerializedFileReader::new(file).expect("Parquet");
    let rows = reader.get_row_iter(None).expect("rows");
    let mut compared = 0;
    for (row, record) in rows.zip(csv.records()) {
        let (row, record) = (row.expect("a row"), record.expect("a line"));
        for ((name, field), (column, text)) in row.get_column_iter().zip(header.iter().zip(&record))
        {
            assert_eq!(name, column);
            let same = match field {
                Field::Null => text.is_empty(),
                Field::Str(value) => value == text,
                Field::Long(value) => value.to_string() == text,
                Field::Bool(value) => value.to_string() == text,
                Field::Double(value) => {
                    text.parse::<f64>().is_ok_and(|read| read.to_bits() == value.to_bits())
                }
                other => panic!("{name}: {other:?}"),
            };
            assert!(same, "{name}: {field:?} is not {text}");
            compared += 1;
        }
    }
    assert_eq!(compared, CELLS * header.len());
}

fn drawn_again() {
    let (place, _) = done();
    place.json("sweep merge out --report merged");
    place.json("bench draw merged/groups-barn.csv --svg again.svg");
    assert!(place.read("again.svg") == place.read("merged/groups-barn.svg"));
}
