//! `inbye bench soak` and `inbye bench ablation`: random missions, their rows and their files.

use std::fs;

use serde_json::Value;

use super::program::{Workplace, assert_fields};

#[test]
fn soak_reports_every_mission() {
    let place = Workplace::new();
    let (_, object) = place.json("bench soak --missions 6 --longest 10 --seed 3 --compare 1");
    assert_fields(
        &object,
        "summary.all.runs whole, summary.all.reached whole, summary.all.reached_share real, \
         summary.all.contacts_robot whole, summary.all.contacts_other whole, summary.all.failed whole, \
         summary.all.timeouts whole, summary.faults object, summary.all.unexplained whole, summary.all.mean_time_s real, \
         summary.all.mean_clearance_reached_m real, summary.mean_speed_m_s real, summary.final_error.mean_m real, \
         summary.final_error.p95_m real, summary.final_error.mean_yaw_rad real, summary.final_error.p95_yaw_rad real, \
         summary.travelled_m real, summary.time_s real, summary.worlds[].name text, summary.worlds[].runs whole, \
         summary.traffic[].name text, summary.plants[].name text, summary.reached.interval_95 list, \
         summary.contacts_robot.interval_95 list, summary.contacts_of_non_yielding.of whole, summary.digests_compared whole, summary.digests_equal whole, sound bool, \
         comparisons[].equal bool, rows[].world text, rows[].seed whole, rows[].traffic text, rows[].plant text, rows[].braking_ratio real, rows[].outcome text, \
         rows[].time_s real, rows[].path_m real, rows[].travelled_m real, rows[].min_clearance_m real, \
         rows[].final_error_m real, rows[].final_yaw_error_rad real, rows[].plans whole, rows[].ticks whole, \
         rows[].trace_digest text, rows[].ran_on text, rows[].tick_p50_ms real, rows[].tick_p99_ms real",
    );
    let summary = &object["summary"];
    assert_eq!(
        (&summary["digests_compared"], &summary["digests_equal"]),
        (&Value::from(1), &Value::from(1))
    );
    let rows = object["rows"].as_array().expect("a list");
    assert_eq!((rows.len(), summary["all"]["unexplained"].as_u64()), (6, Some(0)));
    for row in rows {
        assert_eq!(row["outcome"] == "reached", row["reason"].is_null(), "{row}");
        assert_eq!(row["outcome"] == "contact", !row["contact_cause"].is_null(), "{row}");
    }
    // Each built-in map has its turn.
    assert_eq!(summary["worlds"].as_array().map(Vec::len), Some(4));
}

#[test]
fn soak_resumes_from_its_folder() {
    let place = Workplace::new();
    let soak = "bench soak --maps mine.yaml --missions 3 --longest 8 --threads 1 --out cells --record soak.csv";
    let run = place.run(soak);
    assert!(run.stdout.contains("mine"), "{run:?}");
    let read = || fs::read_to_string(place.path("soak.csv")).expect("the rows are there");
    let whole = read();
    assert_eq!(whole.lines().count(), 4);
    let again = place.run(soak);
    assert_eq!((again.status, read()), (run.status, whole), "{again:?}");
    // More missions drive only the new ones, and merge reads the folder as well.
    place.run(&soak.replace("--missions 3", "--missions 4"));
    let cells = fs::read_dir(place.path("cells/cells")).expect("a folder");
    assert_eq!(cells.count(), 4);
    let merge = place.run("sweep merge cells --report merged --json");
    let merged: Value = serde_json::from_str(&merge.stdout).expect("one JSON object");
    assert_eq!((merge.status, &merged["cells"]), (0, &Value::from(4)), "{merged}");
    // Own tables are replaced, also the times of an earlier merge with latency cells. Other files are not.
    let latency = place.path("merged/latency.csv");
    fs::copy(place.path("merged/sweep.csv"), &latency).expect("a copy");
    assert_eq!(place.run("sweep merge cells --report merged").status, 0);
    let times = fs::read_to_string(latency).expect("a table");
    assert_eq!(times.lines().count(), 1, "{times}");
    let tables = if cfg!(feature = "parquet") { &["csv", "parquet"][..] } else { &["csv"] };
    for extension in tables {
        let (folder, name) = (format!("taken-{extension}"), format!("sweep.{extension}"));
        place.write(&format!("{folder}/{name}"), "PAR1, my notes");
        // The page and the result are worth more than the table.
        let run = place.run(&format!("sweep merge cells --report {folder}"));
        let refusal = run.errors.last().expect("an error");
        assert!(refusal.contains(&format!("{name}: the file exists")), "{run:?}");
        assert!(run.status == 2 && run.stdout.contains("missions"), "{run:?}");
        let kept = fs::read(place.path(&format!("{folder}/{name}"))).expect("still there");
        assert_eq!(kept, b"PAR1, my notes");
    }
}

#[test]
fn soak_replay_writes_page_and_ticks() {
    let place = Workplace::new();
    let soak = "bench soak --maps mine.yaml --missions 3 --longest 8";
    // A map without room is left out with a note.
    place.write("pocket.txt", "#####\n#...#\n#####\n");
    let soak = soak.replace("mine.yaml", "pocket.txt mine.yaml");
    let run = place.run(&format!("{soak} --replay 2 --report out --json"));
    assert_eq!(run.errors.len(), 2, "{run:?}");
    assert!(run.errors[0].starts_with("left out: pocket: no two"), "{run:?}");
    assert_eq!(run.errors[1], "report: out/index.html");
    let row: Value = serde_json::from_str(&run.stdout).expect("standard output is JSON");
    let ticks = fs::read_to_string(place.path("out/ticks.jsonl")).expect("the ticks are there");
    assert_eq!(row["ticks"].as_u64(), Some(ticks.lines().count() as u64));
}

#[test]
fn soak_report_has_a_page_and_its_data() {
    let place = Workplace::new();
    let soak = "bench soak --maps mine.yaml --missions 3 --longest 8";
    let run = place.run(&format!("{soak} --record rows.csv --report out"));
    assert_eq!(run.errors, ["report: out/index.html"]);
    let read = |name: &str| fs::read_to_string(place.path(name)).expect("a file");
    let page = read("out/index.html");
    assert!(page.contains(&format!("inbye {soak} --record rows.csv --report out")));
    assert!(page.contains("Measured on: "), "{page}");
    assert_eq!(page.matches("role=\"img\"").count(), 3);
    assert_eq!(read("out/soak.csv").lines().count(), 4);
    // The record gives the same picture.
    let drawn = place.run("bench draw rows.csv --svg again.svg");
    assert_eq!(drawn.status, 0, "{drawn:?}");
    assert_eq!(read("again.svg"), read("out/soak.svg"));
    let refusal = place.refusal(&format!("{soak} --report mine.yaml"));
    assert!(refusal.contains("--report mine.yaml"), "{refusal}");
}

#[test]
fn ablation_reports_all_variants() {
    let place = Workplace::new();
    let ablation = "bench ablation --maps mine.yaml --missions 2 --longest 8 --people 1";
    let run = place.run(&format!("{ablation} --report out --record rows.csv"));
    assert_eq!(run.status, 0, "{run:?}");
    assert!(run.stdout.contains("A* and DWA as in the paper"), "{run:?}");
    let table =
        fs::read_to_string(place.path("out/ablation.csv")).expect("the table next to the page");
    assert!(table.starts_with("name,kind,config,"), "{table}");
    assert_eq!(table.lines().count(), 1 + 7, "{table}");
    let (status, object) = place.json(&format!("{ablation} --out cells"));
    assert_eq!(status, 0);
    assert_fields(
        &object,
        "variants[].config text, variants[].name text, variants[].runs whole, variants[].reached_share real, \
         variants[].contacts_robot whole, variants[].contacts_other whole, variants[].shared whole, rows[].config text",
    );
    let variants = object["variants"].as_array().expect("a list");
    let names: Vec<&str> =
        variants.iter().map(|row| row["config"].as_str().expect("a word")).collect();
    let expected =
        ["dwa", "astar_dwa", "progress", "tracking", "replanning", "passive_safety", "recovery"];
    assert_eq!(names, expected);
    assert!(variants.iter().all(|row| row["runs"] == 2), "{object}");
    assert_eq!(object["rows"].as_array().map(Vec::len), Some(14));
    let page = fs::read_to_string(place.path("out/index.html")).expect("the page is there");
    assert!(page.ends_with("</html>"));
    assert_eq!(page.matches("role=\"img\"").count(), 2);
    // Its record is drawn again as the page has it.
    let drawn = place.run("bench draw rows.csv --svg again.svg");
    assert_eq!(drawn.status, 0, "{drawn:?}");
    let picture = |name: &str| fs::read_to_string(place.path(name)).expect("a picture");
    assert!(picture("again.svg").contains("A* and DWA as in the paper: "));
    assert_eq!(picture("again.svg"), picture("out/ablation.svg"));
    let own = page.replace("http://www.w3.org/2000/svg", "");
    for outside in ["http:", "https:", "<script", "<link", "url(", "NaN", ">inf<"] {
        assert!(!own.contains(outside), "{outside}");
    }
}

#[test]
fn density_drives_samplings_in_closed_loop() {
    let place = Workplace::new();
    let density =
        "bench density --min-samples 4 --max-samples 64 --seconds 0.01 --ticks 0 --missions 1";
    let (status, object) = place.json(&format!("{density} --record-missions missions.csv"));
    assert_eq!(status, 0, "{object}");
    assert_fields(
        &object,
        "closed_loop[].vx_samples whole, closed_loop[].vtheta_samples whole, closed_loop[].samples whole, \
         closed_loop[].runs whole, closed_loop[].reached whole, closed_loop[].contacts whole, \
         closed_loop[].shared whole, closed_loop[].tick_p50_ms real, closed_loop[].tick_p99_ms real",
    );
    // 64 arcs in two shapes, and 64 motions of two segments.
    assert_eq!(object["closed_loop"].as_array().map(Vec::len), Some(3));
    let rows = fs::read_to_string(place.path("missions.csv")).expect("the rows are there");
    assert_eq!(rows.lines().count(), 4);
    // The record draws the same chart: samplings with their samplers, and no groups of a sweep.
    let drawn = place.run("bench draw missions.csv --report drawn");
    assert_eq!(drawn.status, 0, "{drawn:?}");
    assert!(drawn.stdout.contains("missions with several samplings"), "{drawn:?}");
    let page = fs::read_to_string(place.path("drawn/index.html")).expect("a page");
    for series in ["arcs, v : omega = 1:1", "two_segments, v : omega = 1:16"] {
        assert!(page.contains(series), "{series}");
    }
}

/// Both rows of the table had no name, and the page was that of a soak, with the contacts of both.
#[test]
fn protection_names_the_missions_with_and_without_the_layer() {
    let place = Workplace::new();
    let run = place.run("bench protection --missions 1 --longest 6 --report out");
    for name in ["with the layer", "without the layer"] {
        let rows = run.stdout.lines().filter(|line| line.starts_with(&format!("{name} ")));
        assert_eq!(rows.count(), 1, "{name}: {run:?}");
    }
    let page = fs::read_to_string(place.path("out/index.html")).expect("a page");
    for text in [
        "the protective layer against wrong planners",
        "Wrong planners: ends of the missions",
        "without the layer: contacts by the robot",
    ] {
        assert!(page.contains(text), "{text}");
    }
    assert!(!page.contains("Soak"));
    assert!(place.path("out/protection.csv").exists());
}

#[test]
fn soak_and_ablation_reject_bad_arguments() {
    let place = Workplace::new();
    fs::create_dir(place.path("empty")).expect("the folder can be written to");
    place.write("pocket.txt", "#####\n#...#\n#####\n");
    for (arguments, words) in [
        ("soak --maps pocket.txt", "pocket: no two free places"),
        ("soak --maps gone.yaml", "gone.yaml"),
        ("soak --maps empty", "--maps empty: no .yaml file"),
        ("soak --maps mine.yaml mine.yaml", "two maps are called mine"),
        ("soak --missions 0", "whole number, 1 to 1000000"),
        ("soak --unmapped 2", "0 to 1"),
        ("soak --replay 5", "--report"),
        ("soak --missions 3 --replay 9 --report out", "--replay 9: no mission of these"),
        ("ablation --maps gone.yaml", "gone.yaml"),
        ("ablation --longest 1", "metres, 4 to 10000"),
    ] {
        let refusal = place.refusal(&format!("bench {arguments}"));
        assert!(refusal.contains(words), "{arguments}: {refusal}");
    }
}
