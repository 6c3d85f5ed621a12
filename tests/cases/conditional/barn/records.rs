//! Jobs on several threads, and records of runs.

use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use inbye::bench::{Columns, csv_text};
use inbye::experiment::{Record, RunRow, read_record, run_in_order, run_jobs};

use super::Test;

pub const TESTS: &[Test] = &[
    ("jobs stop at the first error", jobs_stop_at_the_first_error),
    ("results are in the order of the jobs", results_are_in_the_order_of_the_jobs),
    (
        "committed records are read and written to the byte",
        committed_records_are_written_to_the_byte,
    ),
    ("a record with a damaged row is refused", damaged_rows_are_refused),
];

fn jobs_stop_at_the_first_error() {
    let started = AtomicUsize::new(0);
    let jobs: Vec<u64> = (0..1000).collect();
    for threads in [1, 4] {
        started.store(0, Ordering::Relaxed);
        let mut taken = Vec::new();
        let outcome = run_jobs(
            &jobs,
            threads,
            |&job| {
                started.fetch_add(1, Ordering::Relaxed);
                if job == 5 { Err("no fifth") } else { Ok(job) }
            },
            |job| {
                taken.push(job);
                Ok(())
            },
        );
        assert_eq!(outcome, Err("no fifth"));
        assert!(!taken.contains(&5));
    }
    let full: Result<(), &str> = run_jobs(&jobs, 2, |&job| Ok(job), |_| Err("disk full"));
    assert_eq!(full, Err("disk full"));
    let none: Result<(), ()> = run_jobs(&[], 4, |&job: &u64| Ok(job), |_| Ok(()));
    assert_eq!(none, Ok(()));
}

fn results_are_in_the_order_of_the_jobs() {
    let jobs: Vec<u64> = (0..100).collect();
    // The first jobs take longest, so threads finish them out of order.
    let work = |job: &u64| (0..(100 - job) * 1000).fold(*job, |sum, step| sum ^ step) ^ job;
    let expected: Vec<u64> = jobs.iter().map(work).collect();
    for threads in [0, 1, 3, 200] {
        let done = run_in_order(&jobs, threads, |job| Ok::<_, ()>(work(job)), || {});
        assert_eq!(done, Ok(expected.clone()));
    }
    let none = run_in_order(&[], 4, |job: &u64| Ok::<_, ()>(*job), || {});
    assert_eq!(none, Ok(Vec::new()));
}

fn committed_records_are_written_to_the_byte() {
    let records = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/records");
    let folders = fs::read_dir(records).expect("there are records");
    let folders = folders.map(|entry| entry.expect("an entry").path());
    let mut count = 0;
    for folder in folders.filter(|path| path.is_dir()) {
        for entry in fs::read_dir(folder).expect("a folder") {
            let file = entry.expect("an entry").path();
            let name = file.file_name().unwrap_or_default().to_string_lossy();
            let is_runs = ["barn-", "dynabarn-", "soak-"];
            if !is_runs.iter().any(|prefix| name.starts_with(prefix)) {
                continue;
            }
            let text = fs::read_to_string(&file).expect("text");
            let record = read_record(text.as_bytes(), &file).expect("a record");
            let (Record::Barn(rows) | Record::DynaBarn(rows) | Record::Soak(rows)) = record else {
                panic!("{}: {}", file.display(), record.title());
            };
            assert!(csv_text(&rows) == text, "{} differs", file.display());
            count += rows.len();
        }
    }
    assert!(count > 1000, "{count} rows");
}

fn damaged_rows_are_refused() {
    let rows = [0, 1, 2].map(|seed| RunRow {
        world: "a, b".to_owned(),
        reason: Some("one\ntwo\r".to_owned()),
        time_s: 0.5 + seed as f64,
        seed,
        ..RunRow::default()
    });
    let text = csv_text(&rows);
    assert_eq!(text.lines().count(), 4, "a row stays on its line: {text}");
    let read = |text: &str| read_record(text.as_bytes(), Path::new("rows.csv"));
    // Quotation marks around a number are read as well.
    assert!(read(&text.replace(",1.5,", ",\"1.5\",")) == read(&text));
    let fields = RunRow::COLUMNS.len();
    for (from, to, words) in [
        (",1.5,", ",far,", "line 3: time_s: invalid float".to_owned()),
        (",1.5,", ",1.5,1,", format!("line 3: {} fields; expected {fields}", fields + 1)),
        ("outcome", "income", "line 1 has not the columns".to_owned()),
    ] {
        let changed = text.replacen(from, to, 1);
        assert_ne!(changed, text, "{from}");
        let error = read(&changed).expect_err(&words).to_string();
        assert!(error.contains(&words), "{error}");
        assert_eq!(error.lines().count(), 1, "{error}");
    }
}
