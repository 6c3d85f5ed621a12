//! Records that are not well formed.

use std::path::Path;

use inbye::bench::csv_text;
use inbye::experiment::{Record, RunOutcome, RunRow, WorldKind, read_record};

fn record(text: &str) -> Result<Record, String> {
    read_record(text.as_bytes(), Path::new("runs.csv")).map_err(|error| error.to_string())
}

fn soak() -> (String, String) {
    let row = RunRow {
        kind: WorldKind::Missions,
        world: "room".to_owned(),
        vx_samples: 8,
        vtheta_samples: 32,
        engine: "cpu".to_owned(),
        outcome: RunOutcome::Reached,
        ..RunRow::default()
    };
    let text = csv_text(&[row]);
    let (header, row) = text.split_once('\n').expect("a line of names");
    (header.to_owned(), row.to_owned())
}

#[test]
fn record_refuses_a_row_without_values() {
    let (header, row) = soak();
    assert!(
        matches!(record(&format!("{header}\n{row}")), Ok(Record::Soak(rows)) if rows.len() == 1)
    );
    let empty = ",".repeat(header.matches(',').count());
    for bad in [empty.as_str(), "  "] {
        let error = record(&format!("{header}\n{row}{bad}\n")).expect_err("it is no row");
        assert!(error.contains("line 3") && error.contains("correct that line"), "{error}");
    }
}

#[test]
fn record_has_its_columns_also_with_spaces_around_their_names() {
    let (header, row) = soak();
    let spaced = header.replace(',', " , ");
    assert_eq!(record(&format!("{spaced}\n{row}")), record(&format!("{header}\n{row}")));
    let infinite = row.replacen(",0.0,", ",inf,", 1);
    assert_ne!(infinite, row);
    let error = record(&format!("{spaced}\n{infinite}")).expect_err("it is not finite");
    assert!(error.contains("finite number"), "{error}");
}
