//! `inbye bench soak` and `inbye bench ablation`: random missions, their rows and their files.

use std::fs;

use serde_json::Value;

use super::program::{Workplace, assert_fields};

/// Rows of a file without what a clock has a hand in: the two columns before that of the settings.
fn without_times(text: &str) -> Vec<String> {
    let line = |line: &str| {
        let mut parts: Vec<&str> = line.rsplitn(4, ',').collect();
        parts.drain(1..3);
        parts.join(" ")
    };
    text.lines().map(line).collect()
}

#[test]
fn a_soak_tells_of_every_mission() {
    let place = Workplace::new();
    let (_, object) = place.json("bench soak --missions 6 --longest 10 --seed 3 --compare 1");
    assert_fields(
        &object,
        "missions whole, reached whole, reached_share real, contacts_robot whole, contacts_other whole, failed whole, \
         timeouts whole, faults object, unexplained whole, mean_time_s real, mean_clearance_m real, mean_speed_m_s real, \
         final_error.mean_m real, final_error.p95_m real, final_error.mean_yaw_rad real, final_error.p95_yaw_rad real, \
         travelled_m real, time_s real, maps[].name text, maps[].missions whole, people[].name text, \
         digests_compared whole, digests_equal whole, sound bool, comparisons[].equal bool, rows[].map text, \
         rows[].seed whole, rows[].people text, rows[].result text, rows[].time_s real, rows[].path_m real, \
         rows[].travelled_m real, rows[].min_clearance_m real, rows[].contact text, rows[].final_error_m real, \
         rows[].final_yaw_error_rad real, rows[].plans whole, rows[].ticks whole, rows[].trace_digest text, \
         rows[].engine text, rows[].tick_p50_ms real, rows[].tick_p99_ms real",
    );
    assert_eq!(
        (&object["digests_compared"], &object["digests_equal"]),
        (&Value::from(1), &Value::from(1))
    );
    let rows = object["rows"].as_array().expect("a list");
    assert_eq!((rows.len(), object["unexplained"].as_u64()), (6, Some(0)));
    for row in rows {
        assert_eq!(row["result"] == "reached", row["reason"].is_null(), "{row}");
        assert_eq!(row["result"] == "contact", row["contact"] != "-", "{row}");
    }
    // Each map of the built-in ones had its turn.
    assert_eq!(object["maps"].as_array().map(Vec::len), Some(4));
}

#[test]
fn a_soak_that_was_cut_short_goes_on() {
    let place = Workplace::new();
    let soak = "bench soak --maps mine.yaml --missions 3 --longest 8 --threads 1 --record soak.csv";
    let run = place.run(soak);
    assert!(run.stdout.contains("by map"), "{run:?}");
    let file = place.path("soak.csv");
    let whole = fs::read_to_string(&file).expect("the rows are there");
    assert_eq!(whole.lines().count(), 4);
    let torn = whole.len() - 40;
    fs::write(&file, &whole[..torn]).expect("the file can be written");
    let again = place.run(soak);
    assert_eq!(again.status, run.status, "{again:?}");
    let mended = fs::read_to_string(&file).expect("the rows are there");
    assert_eq!(without_times(&mended), without_times(&whole));
    // The rows that were whole were not driven again.
    let kept = whole.lines().count() - 1;
    assert!(mended.lines().take(kept).eq(whole.lines().take(kept)));
    let refusal = place.refusal(&format!("{soak} --people 1"));
    assert!(refusal.contains("other settings"), "{refusal}");
}

#[test]
fn a_mission_can_be_seen_again() {
    let place = Workplace::new();
    let soak = "bench soak --maps mine.yaml --missions 3 --longest 8";
    // A map without room is left out, and that is said.
    place.write("pocket.txt", "#####\n#...#\n#####\n");
    let soak = soak.replace("mine.yaml", "pocket.txt mine.yaml");
    let run = place.run(&format!("{soak} --replay 2 --report out --json"));
    assert_eq!(run.errors.len(), 2, "{run:?}");
    assert!(
        run.errors[0].starts_with("left out: pocket: no two"),
        "{run:?}"
    );
    assert_eq!(run.errors[1], "report: out/index.html");
    let row: Value = serde_json::from_str(&run.stdout).expect("standard output is JSON");
    let ticks = fs::read_to_string(place.path("out/ticks.jsonl")).expect("the ticks are there");
    assert_eq!(row["ticks"].as_u64(), Some(ticks.lines().count() as u64));
}

#[test]
fn a_soak_has_a_page() {
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
fn an_ablation_has_all_variants() {
    let place = Workplace::new();
    let ablation = "bench ablation --maps mine.yaml --missions 2 --longest 8 --people 1";
    let run = place.run(&format!("{ablation} --report out --record rows.csv"));
    assert_eq!(run.status, 0, "{run:?}");
    assert!(run.stdout.contains("A* and DWA as printed"), "{run:?}");
    let table = fs::read_to_string(place.path("out/ablation.csv")).expect("beside the page");
    assert!(
        table.starts_with("variant,title,missions,reached,"),
        "{table}"
    );
    assert_eq!(table.lines().count(), 1 + 7, "{table}");
    // The rows are all there: nothing is driven again.
    let (status, object) = place.json(&format!("{ablation} --record rows.csv"));
    assert_eq!(status, 0);
    assert_fields(
        &object,
        "variants[].variant text, variants[].title text, variants[].missions whole, variants[].reached_share real, \
         variants[].contacts_robot whole, variants[].contacts_other whole, variants[].faults object, \
         variants[].shared whole, rows[].setup text",
    );
    let variants = object["variants"].as_array().expect("a list");
    let names: Vec<&str> = variants
        .iter()
        .map(|row| row["variant"].as_str().expect("a word"))
        .collect();
    let expected = [
        "dwa",
        "astar_dwa",
        "progress",
        "tracking",
        "replanning",
        "passive_safety",
        "recovery",
    ];
    assert_eq!(names, expected);
    assert!(variants.iter().all(|row| row["missions"] == 2), "{object}");
    assert_eq!(object["rows"].as_array().map(Vec::len), Some(14));
    let page = fs::read_to_string(place.path("out/ablation.html")).expect("the page is there");
    assert!(page.ends_with("</html>"));
    assert_eq!(page.matches("role=\"img\"").count(), 2);
    // Its record is drawn again as the page has it.
    let drawn = place.run("bench draw rows.csv --svg again.svg");
    assert_eq!(drawn.status, 0, "{drawn:?}");
    let picture = |name: &str| fs::read_to_string(place.path(name)).expect("a picture");
    assert!(picture("again.svg").contains("A* and DWA as printed: "));
    assert_eq!(picture("again.svg"), picture("out/ablation.svg"));
    let own = page.replace("http://www.w3.org/2000/svg", "");
    for outside in [
        "http:", "https:", "<script", "<link", "url(", "NaN", ">inf<",
    ] {
        assert!(!own.contains(outside), "{outside}");
    }
}

#[test]
fn sampling_densities_are_driven_in_closed_loop() {
    let place = Workplace::new();
    let density =
        "bench density --min-samples 4 --max-samples 64 --seconds 0.01 --ticks 0 --missions 1";
    let (status, object) = place.json(&format!("{density} --record-missions missions.csv"));
    assert_eq!(status, 0, "{object}");
    assert_fields(
        &object,
        "closed_loop[].vx_samples whole, closed_loop[].vtheta_samples whole, closed_loop[].samples whole, \
         closed_loop[].missions whole, closed_loop[].reached whole, closed_loop[].contacts whole, \
         closed_loop[].shared whole, closed_loop[].tick_p50_ms real, closed_loop[].tick_p99_ms real",
    );
    // 64 samples in two shapes.
    assert_eq!(object["closed_loop"].as_array().map(Vec::len), Some(2));
    let rows = fs::read_to_string(place.path("missions.csv")).expect("the rows are there");
    assert_eq!(rows.lines().count(), 3);
}

#[test]
fn missions_that_cannot_be_are_refused() {
    let place = Workplace::new();
    fs::create_dir(place.path("empty")).expect("the folder can be written to");
    place.write("pocket.txt", "#####\n#...#\n#####\n");
    for (arguments, words) in [
        ("soak --maps pocket.txt", "pocket: no two free places"),
        ("soak --maps gone.yaml", "gone.yaml"),
        ("soak --maps empty", "--maps empty: no .yaml file"),
        (
            "soak --maps mine.yaml mine.yaml",
            "two maps are called mine",
        ),
        ("soak --missions 0", "whole number, 1 to 1000000"),
        ("soak --unmapped 2", "0 to 1"),
        ("soak --replay 5", "--report"),
        (
            "soak --missions 3 --replay 9 --report out",
            "--replay 9: no mission of these",
        ),
        ("ablation --maps gone.yaml", "gone.yaml"),
        ("ablation --longest 1", "metres, 4 to 10000"),
    ] {
        let refusal = place.refusal(&format!("bench {arguments}"));
        assert!(refusal.contains(words), "{arguments}: {refusal}");
    }
}
