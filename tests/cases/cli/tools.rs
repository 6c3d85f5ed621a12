//! `inbye verify`, `inbye devices`, `inbye bench density`, and missing graphics adapters.

use std::fs;

use super::program::{Workplace, assert_fields};

#[test]
fn verify_compares_engines() {
    let place = Workplace::new();
    let (status, object) = place.json("verify --cases 5 --seed 2");
    assert_eq!(status, 0);
    assert_fields(
        &object,
        "cases whole, engines list, engines[].name text, engines[].digest text, engines[].golden_digest text, golden_digest text, agree bool",
    );
    assert_eq!((object["cases"].as_u64(), object["agree"].as_bool()), (Some(5), Some(true)));
    for engine in object["engines"].as_array().unwrap() {
        assert_eq!(engine["golden_digest"], object["golden_digest"]);
    }
    let digest = |object: &serde_json::Value| object["engines"][0]["digest"].clone();
    assert_eq!(digest(&object), digest(&place.json("verify --cases 5 --seed 2").1));
    assert_ne!(digest(&object), digest(&place.json("verify --cases 5 --seed 3").1));
    let run = place.run("verify --cases 2");
    assert!(run.stdout.starts_with("2 problems, ") && run.stdout.contains("agree: "), "{run:?}");
}

#[test]
fn problems_of_any_seed_are_within_the_ranges_of_a_problem() {
    let place = Workplace::new();
    // The key node of this problem was drawn 65.04 m from the start; the range is 64 m.
    let (status, object) = place.json("verify --cases 1 --seed 6824013776580330788");
    assert_eq!((status, object["agree"].as_bool()), (0, Some(true)), "{object}");
}

#[test]
fn devices_lists_adapters_and_cpu() {
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

/// A very short measurement.
const QUICK: &str =
    "bench density --min-samples 4 --max-samples 16 --seconds 0.01 --ticks 2 --missions 0";

#[test]
fn density_measures_latency() {
    let place = Workplace::new();
    let (status, object) = place.json(&format!("{QUICK} --record rows.csv"));
    assert_eq!(status, 0);
    assert_fields(
        &object,
        "rows list, rows[].engine text, rows[].threads whole, rows[].samples whole, rows[].steps whole, \
         rows[].p50_ms real, rows[].p95_ms real, rows[].p99_ms real, rows[].max_ms real, rows[].decisions whole, \
         rows[].steps_per_s real, rows[].name text, rows[].missed_20_hz whole, rows[].missed_50_hz whole, \
         rows[].missed_100_hz whole, skipped list, crossover list, batches[].name text, batches[].engine text, \
         batches[].batch whole, batches[].samples whole, batches[].steps whole, batches[].p50_ms real, batches[].p99_ms real, \
         batches[].decisions_hz real, batches[].batches whole, quality list, closed_loop list",
    );
    let rows = object["rows"].as_array().unwrap();
    // The key exists for engines without an adapter, too.
    assert!(rows.iter().all(|row| row.as_object().unwrap().contains_key("adapter")));
    assert!(rows.iter().all(|row| row["steps"] == 40), "{object}");
    let samples = |count: u64| rows.iter().filter(move |row| row["samples"] == count).count();
    assert!(samples(4) > 0 && samples(4) == samples(16), "{object}");
    for row in rows {
        let count = |field: &str| row[field].as_u64().expect("a whole number");
        let decisions = count("decisions");
        // A decision that misses a slow deadline misses a faster one.
        let late = ["missed_20_hz", "missed_50_hz", "missed_100_hz"].map(count);
        assert!(late.is_sorted() && late[2] <= decisions, "{row}");
        assert!(row["name"].as_str().unwrap().starts_with("CPU, "), "{row}");
    }
    // Without an adapter no engine overtakes the CPU.
    assert_eq!(object["crossover"], serde_json::json!([]));
    let table = fs::read_to_string(place.path("rows.csv")).expect("the record is there");
    assert_eq!(table.lines().count(), rows.len() + 1);
    assert_eq!(
        table.lines().next(),
        Some(
            "engine,adapter,threads,sampler,samples,steps,p50_ms,p95_ms,p99_ms,max_ms,decisions,steps_per_s,\
             name,missed_20_hz,missed_50_hz,missed_100_hz"
        )
    );
    let alone = QUICK.replace("--ticks 2", "--ticks 0");
    let run =
        place.run(&format!("{alone} --steps 7 --record rows.json --record-quality quality.csv"));
    assert_eq!(run.status, 0, "{run:?}");
    let record = fs::read_to_string(place.path("rows.json")).expect("the record is there");
    let rows: Vec<serde_json::Value> = serde_json::from_str(&record).expect("the record is JSON");
    let tables = run.stdout.lines().skip_while(|line| !line.starts_with("name"));
    let printed = tables.skip(1).take_while(|line| !line.is_empty());
    assert_eq!(rows.len(), printed.count(), "{run:?}");
    assert!(rows.iter().all(|row| row["steps"] == 7));
    let nothing = fs::read_to_string(place.path("quality.csv")).expect("the record is there");
    assert_eq!(nothing.lines().count(), 1, "{nothing}");
}

#[test]
fn density_compares_commands_with_densest_sampling() {
    let place = Workplace::new();
    let files = "--record-quality quality.csv --chart density.svg";
    let (status, object) = place.json(&format!("{QUICK} {files}"));
    assert_eq!(status, 0);
    assert_fields(
        &object,
        "quality[].window_s real, quality[].sampler text, quality[].samples whole, quality[].vx_samples whole, \
         quality[].vtheta_samples whole, quality[].densest whole, quality[].decisions whole, \
         quality[].without_command whole, quality[].regret_p50 real, quality[].regret_max real, \
         quality[].v_off_p50_m_s real, quality[].v_off_max_m_s real, quality[].omega_off_p50_rad_s real, \
         quality[].omega_off_max_rad_s real",
    );
    let rows = object["quality"].as_array().unwrap();
    // Two densities, two windows, four samplers.
    assert_eq!(rows.len(), 16, "{object}");
    for row in rows {
        assert_eq!((row["densest"].as_u64(), row["decisions"].as_u64()), (Some(1 << 20), Some(2)));
        assert!(row["regret_p50"].as_f64() <= row["regret_max"].as_f64(), "{row}");
        assert!(row["regret_p50"].as_f64() >= Some(0.0), "{row}");
    }
    // These do not depend on the clock.
    let again = place.json(&format!("{QUICK} {files}")).1;
    assert_eq!(again["quality"], object["quality"]);
    let table = fs::read_to_string(place.path("quality.csv")).expect("the record is there");
    let columns = |line: &str| line.split(',').count();
    assert_eq!(table.lines().count(), rows.len() + 1, "{table}");
    assert!(table.lines().all(|line| columns(line) == 14), "{table}");
    let picture = fs::read_to_string(place.path("density.svg")).expect("the picture is there");
    assert!(picture.starts_with("<svg") && picture.contains("window 0.1 s"), "{picture}");
    let run = place.run(QUICK);
    assert!(run.stdout.contains("compared with the one chosen from 1048576 samples"), "{run:?}");
}

#[cfg(target_os = "linux")]
#[test]
fn missing_adapter_fails_for_gpu_and_falls_back_for_auto() {
    let place = Workplace::new();
    let ends = "drive --map mine.yaml --start 10,5 --goal 12,5";
    for engine in ["gpu", "gpu:NoSuchAdapter"] {
        let refusal = place.refusal(&format!("{ends} --engine {engine}"));
        assert!(refusal.contains("--engine cpu"), "{refusal}");
    }
    let (status, object) = place.json(&format!("{ends} --engine auto"));
    assert_eq!(status, 0);
    assert!(object["engine"].as_str().unwrap().starts_with("CPU"), "{object}");
    let run = place.run(&format!("{ends} --engine auto"));
    assert!(run.engine_note.unwrap().contains("fastest for"));
    assert_eq!(place.json("devices").1["adapters"], serde_json::json!([]));
    // The drivers' own reason, and the variable that hides the installed ones.
    let reason = place.json("devices").1["no_adapter"].as_str().unwrap_or_default().to_owned();
    if cfg!(feature = "gpu") {
        assert!(reason.starts_with("no adapter found: Vulkan backend: "), "{reason}");
        let devices = place.run("devices").stdout;
        assert!(devices.contains(&reason) && devices.contains("VK_ICD_FILENAMES"), "{devices}");
        let checks = place.json("doctor --seconds 0.01").1["checks"].clone();
        let checks = checks.as_array().expect("checks");
        assert!(checks.iter().any(|check| check["text"] == reason), "{checks:?}");
    }
}
