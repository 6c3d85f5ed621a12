//! Latency cells, which run alone on the machine.

use serde_json::Value;

use super::Test;
use super::plan_folder::{PLAN, PlanFolder};

pub const TESTS: &[Test] = &[
    ("no other cell runs during a latency cell", latency_cells_run_alone),
    ("latencies have their own table", own_table),
];

/// The plan, with one of its two worlds measured.
fn measured(place: &PlanFolder) {
    let half = PLAN.replace("[0, 1, 2]", "[0, 1]").replace("\"8x16\", ", "");
    let plan = half.clone()
        + "only = [3]\nlatency = true\n[[worlds]]\nkind = \"barn\"\npath = \"barn\"\nonly = [12]\n";
    place.write("measured.toml", plan);
}

/// The begin and end of each cell, and whether it is a latency cell.
fn spans(place: &PlanFolder, out: &str) -> Vec<(f64, f64, bool)> {
    let listed = place.json("sweep measured.toml --list");
    let cells = listed["cells"].as_array().expect("a list");
    let log = place.log(out);
    let at = |key: &Value, event: &str| {
        let line = log.iter().find(|line| line["key"] == *key && line["event"] == event);
        line.expect("each cell is in the log")["unix_s"].as_f64().expect("a time")
    };
    cells
        .iter()
        .map(|cell| {
            let (begun, finished) = (at(&cell["key"], "begun"), at(&cell["key"], "finished"));
            (begun, finished, cell["latency"] == true)
        })
        .collect()
}

fn latency_cells_run_alone() {
    let place = PlanFolder::new();
    measured(&place);
    // The two folders share only the machine.
    let mut processes = [
        place.start("sweep measured.toml --out a --jobs 2"),
        place.start("sweep measured.toml --out b --jobs 2"),
    ];
    for process in &mut processes {
        assert!(process.wait().expect("it ends").success());
    }
    let all = [spans(&place, "a"), spans(&place, "b")].concat();
    let mut compared = 0;
    for (index, &(begun, finished, is_alone)) in all.iter().enumerate() {
        for (_, other) in all.iter().enumerate().filter(|(other, _)| *other != index && is_alone) {
            let apart = other.1 <= begun || finished <= other.0;
            assert!(apart, "{:?} and {other:?} overlap", all[index]);
            compared += 1;
        }
    }
    assert_eq!(compared, 8 * 15, "of 16 cells 8 measure");
}

fn own_table() {
    let place = PlanFolder::new();
    measured(&place);
    for out in ["a", "b"] {
        place.json(&format!("sweep measured.toml --out {out}"));
        place.json(&format!("sweep merge {out} --report {out}-merged"));
    }
    assert!(place.read("a-merged/sweep.csv") == place.read("b-merged/sweep.csv"));
    let times = String::from_utf8(place.read("a-merged/latency.csv")).expect("text");
    assert_eq!(times.lines().count(), 1 + 4, "{times}");
    assert!(times.lines().skip(1).all(|line| line.starts_with("barn,3,")), "{times}");
    let page = String::from_utf8(place.read("a-merged/index.html")).expect("text");
    assert!(page.contains("Latency of a tick"));
    // The result is the same with and without a clock; the key of the cell differs.
    let table = String::from_utf8(place.read("a-merged/sweep.csv")).expect("text");
    assert!(table.lines().skip(1).all(|line| !line.contains("error")), "{table}");
}
