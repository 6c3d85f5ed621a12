//! A campaign that was cut short anywhere ends with the same file.

use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use inbye::bench::Columns;
use inbye::experiment::barn::BarnRow;
use inbye::experiment::campaign::{CampaignError, Ledger, Row, run_cells, settings_digest};
use inbye::experiment::dynabarn::DynaBarnRow;
use inbye::experiment::missions::MissionRow;
use serde::{Deserialize, Serialize};

use super::Test;

pub const TESTS: &[Test] = &[
    ("a file cut at any byte is made whole again", cut_anywhere),
    ("the file does not depend on the threads", threads),
    ("an error ends a campaign and keeps what there is", stops),
    ("files of something else are refused", refuses),
    ("rows with needless quotation marks are read", quoted),
    ("a text with a line break stays on its line", breaks),
    (
        "the records kept here are read and written to the byte",
        records,
    ),
    ("other settings have another digest", digests),
];

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Line {
    number: u64,
    root: f64,
    word: Option<String>,
    even: bool,
}

impl Columns for Line {
    const COLUMNS: &[&str] = &["number", "root", "word", "even"];
}

impl Row for Line {
    type Key = u64;

    fn key(&self) -> u64 {
        self.number
    }
}

/// What a run gives.
fn line(number: u64) -> Line {
    Line {
        number,
        root: (number as f64).sqrt() - 1.0,
        word: number
            .is_multiple_of(3)
            .then(|| format!("three, or \"{number}\"")),
        even: number.is_multiple_of(2),
    }
}

const CELLS: u64 = 12;
const SETTINGS: &str = "0123456789e7";

/// Goes on from a file, up to so many further runs; the file as it then is.
fn go_on(held: &[u8], runs: usize, threads: usize) -> String {
    let (mut ledger, whole) =
        Ledger::<Line>::read(held, Path::new("rows.csv"), SETTINGS).expect("its own file");
    let mut file = String::from_utf8(held[..whole].to_vec()).expect("text");
    if file.is_empty() {
        file += &ledger.header();
    }
    let open: Vec<u64> = (0..CELLS)
        .filter(|cell| !ledger.has(cell))
        .take(runs)
        .collect();
    let done: Result<(), ()> = run_cells(
        &open,
        threads,
        |&cell| Ok(line(cell)),
        |row| {
            file += &ledger.line(&row);
            ledger.add(row);
            Ok(())
        },
    );
    assert_eq!(done, Ok(()));
    if ledger.rows().count() == CELLS as usize {
        ledger.text()
    } else {
        file
    }
}

fn cut_anywhere() {
    let whole = go_on(&[], usize::MAX, 1);
    assert_eq!(whole.lines().count(), 1 + CELLS as usize);
    assert_eq!(whole.lines().next(), Some("number,root,word,even,settings"));
    assert!(
        whole.contains("\n3,0.7320508075688772,\"three, or \"\"3\"\"\",false,0123456789e7\n"),
        "{whole}"
    );
    // A header cut short is torn as well.
    for end in 0..whole.len() {
        assert_eq!(
            go_on(&whole.as_bytes()[..end], usize::MAX, 1),
            whole,
            "cut at {end}"
        );
    }
    let mut file = String::new();
    for _ in 0..CELLS {
        file = go_on(file.as_bytes(), 1, 1);
    }
    assert_eq!(file, whole);
    // And again with nothing left to do.
    assert_eq!(go_on(file.as_bytes(), usize::MAX, 4), whole);
}

fn threads() {
    let one = go_on(&[], usize::MAX, 1);
    for threads in [2, 3, 8, 64] {
        assert_eq!(go_on(&[], usize::MAX, threads), one, "{threads} threads");
    }
}

fn stops() {
    let begun = AtomicUsize::new(0);
    let cells: Vec<u64> = (0..1000).collect();
    for threads in [1, 4] {
        begun.store(0, Ordering::Relaxed);
        let mut taken = Vec::new();
        let outcome = run_cells(
            &cells,
            threads,
            |&cell| {
                begun.fetch_add(1, Ordering::Relaxed);
                if cell == 5 { Err("no fifth") } else { Ok(cell) }
            },
            |cell| {
                taken.push(cell);
                Ok(())
            },
        );
        assert_eq!(outcome, Err("no fifth"));
        assert!(!taken.contains(&5));
    }
    let full: Result<(), &str> = run_cells(&cells, 2, |&cell| Ok(cell), |_| Err("disk full"));
    assert_eq!(full, Err("disk full"));
    let none: Result<(), ()> = run_cells(&[], 4, |&cell: &u64| Ok(cell), |_| Ok(()));
    assert_eq!(none, Ok(()));
}

fn refuses() {
    let whole = go_on(&[], usize::MAX, 1);
    let read = |text: &str, settings| {
        let file = Path::new("rows.csv");
        Ledger::<Line>::read(text.as_bytes(), file, settings).map(|_| ())
    };
    let error = read(&whole, "other").expect_err("other settings");
    assert!(matches!(
        error,
        CampaignError::OtherSettings { line: 2, .. }
    ));
    let error = error.to_string();
    assert!(
        error.contains("rows.csv: line 2") && error.contains("0123456789e7"),
        "{error}"
    );
    for (from, to, words) in [
        ("number,root", "number,route", "line 1 is no header"),
        ("\n4,1.0,", "\n4,1.0,1,", "line 6: 6 fields; expected 5"),
        ("\n4,1.0,", "\n4,far,", "line 6: root: invalid float"),
        ("\n4,1.0,", "\n3,1.0,", "line 6: a second row of 3"),
        ("\n4,1.0,", "\n,1.0,", "line 6: number: "),
        ("\"three", "\"\"three", "line 2: 6 fields; expected 5"),
    ] {
        assert!(whole.contains(from), "{from}");
        let error = read(&whole.replacen(from, to, 1), SETTINGS)
            .expect_err(words)
            .to_string();
        assert!(error.contains(words), "{error}");
        assert_eq!(error.lines().count(), 1, "{error}");
    }
    assert_eq!(read("", SETTINGS), Ok(()));
}

/// As they were once written about texts that look like numbers.
fn quoted() {
    let whole = go_on(&[], usize::MAX, 1);
    let marked = whole.replace(SETTINGS, &format!("\"{SETTINGS}\""));
    assert_ne!(marked, whole);
    assert_eq!(go_on(marked.as_bytes(), usize::MAX, 1), whole);
}

fn records() {
    let rows = same_again::<BarnRow>("barn-")
        + same_again::<DynaBarnRow>("dynabarn-")
        + same_again::<MissionRow>("soak-");
    assert!(rows > 1000, "{rows} rows");
}

/// Rows of all records whose files are called so.
fn same_again<R: Row>(prefix: &str) -> usize {
    let records = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/records");
    let folders = fs::read_dir(records).expect("there are records");
    let folders = folders.map(|entry| entry.expect("an entry").path());
    let mut rows = 0;
    for folder in folders.filter(|path| path.is_dir()) {
        for entry in fs::read_dir(folder).expect("a folder") {
            let file = entry.expect("an entry").path();
            let name = file.file_name().unwrap_or_default().to_string_lossy();
            if !name.starts_with(prefix) {
                continue;
            }
            let text = fs::read_to_string(&file).expect("text");
            let (_, settings) = text.trim_end().rsplit_once(',').expect("columns");
            let (ledger, whole) =
                Ledger::<R>::read(text.as_bytes(), &file, settings).expect("a record");
            assert_eq!(whole, text.len());
            assert!(ledger.text() == text, "{} differs", file.display());
            rows += ledger.rows().count();
        }
    }
    rows
}

fn breaks() {
    let ledger = Ledger::<Line>::new(SETTINGS);
    let broken = Line {
        word: Some("one\ntwo\r".to_owned()),
        ..line(1)
    };
    assert_eq!(ledger.line(&broken), "1,0.0,one two ,false,0123456789e7\n");
}

fn digests() {
    let digest = |speed: f64| settings_digest(&inbye::experiment::barn::barn_config(speed));
    assert_eq!(digest(2.0), digest(2.0));
    assert_ne!(digest(2.0), digest(0.5));
    assert_eq!(digest(2.0).len(), 12);
}
