//! `inbye verify`, `inbye devices`, `inbye bench density`, and graphics adapters that are not there.

use std::fs;

use crate::program::{Workplace, assert_fields};

#[test]
fn verify_compares_engines() {
    let place = Workplace::new();
    let (status, object) = place.json("verify --cases 5 --seed 2");
    assert_eq!(status, 0);
    assert_fields(
        &object,
        "cases whole, engines list, engines[].name text, engines[].digest text, engines[].golden_digest text, golden_digest text, agree bool",
    );
    assert_eq!(
        (object["cases"].as_u64(), object["agree"].as_bool()),
        (Some(5), Some(true))
    );
    for engine in object["engines"].as_array().unwrap() {
        assert_eq!(engine["golden_digest"], object["golden_digest"]);
    }
    let digest = |object: &serde_json::Value| object["engines"][0]["digest"].clone();
    assert_eq!(
        digest(&object),
        digest(&place.json("verify --cases 5 --seed 2").1)
    );
    assert_ne!(
        digest(&object),
        digest(&place.json("verify --cases 5 --seed 3").1)
    );
    let run = place.run("verify --cases 2");
    assert!(
        run.stdout.starts_with("2 problems, ") && run.stdout.contains("agree: "),
        "{run:?}"
    );
}

#[test]
fn devices_are_listed() {
    let place = Workplace::new();
    let (status, object) = place.json("devices");
    assert_eq!(status, 0);
    assert_fields(
        &object,
        "adapters list, cpu object, cpu.cores whole, cpu.architecture text, cpu.features list",
    );
    let run = place.run("devices");
    assert!(run.stdout.starts_with("CPU: "), "{run:?}");
}

#[test]
fn density_is_measured() {
    let place = Workplace::new();
    let few = "bench density --min-samples 4 --max-samples 16 --seconds 0.01";
    let (status, object) = place.json(&format!("{few} --record rows.csv"));
    assert_eq!(status, 0);
    assert_fields(
        &object,
        "rows list, rows[].engine text, rows[].threads whole, rows[].samples whole, rows[].steps whole, \
         rows[].p50_ms real, rows[].p99_ms real, rows[].steps_per_s real",
    );
    let rows = object["rows"].as_array().unwrap();
    // The key is there even for an engine without an adapter.
    assert!(
        rows.iter()
            .all(|row| row.as_object().unwrap().contains_key("adapter"))
    );
    assert!(rows.iter().all(|row| row["steps"] == 40), "{object}");
    let samples = |count: u64| {
        rows.iter()
            .filter(move |row| row["samples"] == count)
            .count()
    };
    assert!(samples(4) > 0 && samples(4) == samples(16), "{object}");
    let table = fs::read_to_string(place.path("rows.csv")).expect("the record is there");
    assert_eq!(table.lines().count(), rows.len() + 1);
    assert!(
        table.starts_with("engine,adapter,threads,samples,"),
        "{table}"
    );
    let run = place.run(&format!("{few} --steps 7 --record rows.json"));
    assert_eq!(run.status, 0, "{run:?}");
    let record = fs::read_to_string(place.path("rows.json")).expect("the record is there");
    let rows: Vec<serde_json::Value> = serde_json::from_str(&record).expect("the record is JSON");
    assert_eq!(rows.len() + 1, run.stdout.lines().count(), "{run:?}");
    assert!(rows.iter().all(|row| row["steps"] == 7));
}

#[cfg(target_os = "linux")]
#[test]
fn without_an_adapter_a_gpu_is_refused_and_auto_takes_the_cpu() {
    let place = Workplace::new();
    let ends = "drive --map mine.yaml --start 10,5 --goal 12,5";
    for engine in ["gpu", "gpu:NoSuchAdapter"] {
        let refusal = place.refusal(&format!("{ends} --engine {engine}"));
        assert!(refusal.contains("--engine cpu"), "{refusal}");
    }
    let (status, object) = place.json(&format!("{ends} --engine auto"));
    assert_eq!(status, 0);
    assert!(
        object["engine"].as_str().unwrap().starts_with("CPU"),
        "{object}"
    );
    let run = place.run(&format!("{ends} --engine auto"));
    assert!(run.engine_note.unwrap().contains("no GPU adapter found"));
    assert_eq!(place.json("devices").1["adapters"], serde_json::json!([]));
}
