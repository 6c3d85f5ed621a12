//! `inbye bench dynabarn`.

use std::fs;

use serde_json::{Value, json};

use super::program::{Workplace, assert_fields};

/// A cylinder that crosses a path of six metres, and one next to it.
const FOUR: &str = r#"{"world": 4, "start_x_y_yaw": [3, 0, 3.14], "goal_x_y": [-3, 0], "obstacles": [
    {"name": "a", "radius_m": 0.5, "loop_s": 9, "keyframes_t_x_y": [[0, 0, -2], [4.5, 0, 2], [9, 0, -2]]},
    {"name": "b", "radius_m": 0.5, "loop_s": 9, "keyframes_t_x_y": [[0, 1, 3]]}]}"#;
/// A cylinder that cannot be evaded.
const SIX: &str = r#"{"world": 6, "start_x_y_yaw": [3, 0, 3.14], "goal_x_y": [-3, 0], "obstacles": [
    {"name": "a", "radius_m": 6, "loop_s": 2, "keyframes_t_x_y": [[0, 16, 0], [2, -20, 0]]}]}"#;

const BENCH: &str = "bench dynabarn --worlds dynabarn";

pub fn write_worlds(place: &Workplace) {
    place.write("dynabarn/world_04.json", FOUR);
    place.write("dynabarn/world_06.json", SIX);
}

fn place() -> Workplace {
    let place = Workplace::new();
    write_worlds(&place);
    place
}

#[test]
fn dynabarn_attributes_contacts() {
    let place = place();
    let (status, object) = place.json(&format!("{BENCH} --threads 2 --out runs --record runs.csv"));
    assert_eq!(status, 0);
    assert_fields(
        &object,
        "summary.worlds whole, summary.runs whole, summary.reached whole, summary.reached_share real, \
         summary.attributed_share real, summary.contacts whole, summary.contacts_robot whole, \
         summary.contacts_avoidable whole, summary.contacts_other whole, summary.timeouts whole, summary.failed whole, \
         summary.mean_time_s real, simulator text, rows list, rows[].world text, rows[].seed whole, rows[].outcome text, \
         rows[].time_s real, rows[].travelled_m real, rows[].min_clearance_m real, rows[].plans whole, rows[].fault null, \
         rows[].tick_p50_ms real, rows[].tick_p99_ms real",
    );
    let ends = |row: &Value| (row["outcome"].clone(), row["contact_cause"].clone());
    let rows = object["rows"].as_array().expect("rows");
    assert_eq!(
        rows.iter().map(ends).collect::<Vec<_>>(),
        [(json!("reached"), json!(null)), (json!("contact"), json!("other"))],
        "{object}"
    );
    // The contact counts in the one share and not in the other.
    assert_eq!(object["summary"]["reached_share"], json!(0.5));
    assert_eq!(object["summary"]["attributed_share"], json!(1.0));

    // What is in the folder is not driven again: the times are the same.
    let record = fs::read_to_string(place.path("runs.csv")).expect("a record");
    assert!(record.contains("\ndynabarn,4,,,20,41,cpu,0,false,reached,"), "{record}");
    let run = place.run(&format!("{BENCH} --out runs --record runs.csv"));
    assert_eq!((run.status, run.errors.len()), (0, 0), "{run:?}");
    for words in
        ["not Gazebo", "on a spline through their keyframes", "world 6, seed 0: was hit after"]
    {
        assert!(run.stdout.contains(words), "{run:?}");
    }
    let again = fs::read_to_string(place.path("runs.csv")).expect("a record");
    assert_eq!(again, record);
}

#[test]
fn dynabarn_trace_draws_and_writes_one_run() {
    let place = place();
    let (status, row) = place.json(&format!("{BENCH} --trace 4,1 --svg run.svg --ticks run.jsonl"));
    assert_eq!(status, 0);
    assert_eq!((&row["world"], &row["seed"]), (&json!("4"), &json!(1)));
    let picture = fs::read_to_string(place.path("run.svg")).expect("a picture");
    assert!(picture.contains("DynaBARN world 4, seed 1"), "{picture}");
    let ticks = fs::read_to_string(place.path("run.jsonl")).expect("ticks");
    let last: Value = serde_json::from_str(ticks.lines().last().unwrap()).expect("JSON");
    assert_eq!(last["time_s"], row["time_s"]);
    assert_eq!(last["moving"].as_array().map(Vec::len), Some(2));
}

#[test]
fn dynabarn_rejects_bad_arguments_and_files() {
    let place = place();
    place.write("typo.toml", "[navigator]\nlookahed_m = 1.0\n");
    place.write("none/world.txt", "");
    let table = "
 -> --worlds; --help
--worlds gone -> gone: cannot be read
--worlds none -> none: holds no world_NN.json
--worlds dynabarn --only 5 -> world 5 is not among the 2; 4, 6
--worlds dynabarn --config typo.toml -> typo.toml; lookahed_m
--worlds dynabarn --trace 5,0 -> world 5 is not among
--worlds dynabarn --trace 4,0 --svg run.png -> --svg run.png; .svg
--worlds dynabarn --ticks run.jsonl -> --trace
";
    for line in table.lines().filter(|line| !line.is_empty()) {
        let (arguments, words) = line.split_once(" -> ").expect("a line has an arrow");
        let refusal = place.refusal(&format!("bench dynabarn {arguments}"));
        for word in words.split("; ") {
            assert!(refusal.contains(word), "{arguments}: no {word:?} in: {refusal}");
        }
    }
}

/// Its cylinders are not in the world of another simulator.
#[test]
fn dynabarn_has_no_other_simulator() {
    let place = place();
    let error = place.refusal(&format!("{BENCH} --simulator cat"));
    assert!(error.contains("--simulator: the cylinders of DynaBARN"), "{error}");
    place.write("own.toml", "simulator.command = [\"cat\"]\n");
    let error = place.refusal(&format!("{BENCH} --config own.toml --trace 4,0"));
    assert!(error.contains("own.toml: [simulator]: the cylinders of DynaBARN"), "{error}");
}
