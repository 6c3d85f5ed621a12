//! A campaign that was cut short anywhere ends with the same file.

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use inbye::bench::campaign::{CampaignError, Ledger, Row, run_cells, settings_digest};
use serde::{Deserialize, Serialize};

use crate::Test;

pub const TESTS: &[Test] = &[
    ("a file cut at any byte is made whole again", cut_anywhere),
    ("the file does not depend on the threads", threads),
    ("an error ends a campaign and keeps what there is", stops),
    ("files of something else are refused", refuses),
    ("other settings have another digest", digests),
];

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Line {
    number: u64,
    root: f64,
    word: Option<String>,
    even: bool,
}

impl Row for Line {
    type Key = u64;

    const COLUMNS: &[&str] = &["number", "root", "word", "even"];

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
        whole.contains("\n3,0.7320508075688772,\"three, or \"\"3\"\"\",false,\"0123456789e7\"\n"),
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
        ("\n4,1.0,", "\n4,far,", "line 6: invalid type"),
        ("\n4,1.0,", "\n3,1.0,", "line 6: a second row of 3"),
        ("\n4,1.0,", "\n,1.0,", "line 6: invalid type"),
        ("\"three", "\"\"three", "a quotation is not closed"),
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

fn digests() {
    let digest = |speed: f64| settings_digest(&inbye::bench::barn::barn_config(speed));
    assert_eq!(digest(2.0), digest(2.0));
    assert_ne!(digest(2.0), digest(0.5));
    assert_eq!(digest(2.0).len(), 12);
}
