//! `inbye plan`.

use std::process::Stdio;

use serde_json::{Value, json};

use crate::program::{Workplace, assert_fields};

const ENDS: &str = "plan --map mine.yaml --start 10,5 --goal 80,40";

/// A room in two halves; a character is a metre.
const HALVES: &str = "#############\n#.....#.....#\n#.....#.....#\n#.....#.....#\n#############\n";

#[test]
fn the_object_has_every_field() {
    let place = Workplace::new();
    let (status, object) = place.json(ENDS);
    assert_eq!(status, 0);
    assert_fields(
        &object,
        "found bool, path list, length_m real, turns whole, min_clearance_m real, expanded whole, \
         raw.length_m real, raw.points whole, raw.turns whole, \
         pruned.length_m real, pruned.points whole, pruned.turns whole, \
         time_ms.search real, time_ms.prune real, time_ms.smooth real, time_ms.total real",
    );
    assert_eq!(object["found"], true);
    let path = object["path"].as_array().unwrap();
    assert_eq!(
        (&path[0], &path[path.len() - 1]),
        (&json!([10.0, 5.0]), &json!([80.0, 40.0]))
    );
    // The wall at 49.5 to 50.5 m ends at 50 m; nothing is shorter than by way of the corner.
    let corner = libm::hypot(39.5, 45.0) + 1.0 + libm::hypot(29.5, 10.0);
    let length_m = object["length_m"].as_f64().unwrap();
    assert!(
        length_m > corner && length_m < corner * 1.1,
        "{length_m} over {corner}"
    );
    assert!(object["raw"]["length_m"].as_f64().unwrap() >= length_m);
    // The circle about the default robot is 0.42 m.
    assert!(object["min_clearance_m"].as_f64().unwrap() > 0.42);
}

#[test]
fn people_read_the_same_numbers() {
    let place = Workplace::new();
    let (_, object) = place.json(ENDS);
    let run = place.run(ENDS);
    assert_eq!((run.status, run.errors.len()), (0, 0), "{run:?}");
    let words: Vec<&str> = run.stdout.split_whitespace().collect();
    for stage in ["searched", "pruned", "smoothed", "clearance", "expanded),"] {
        assert!(words.contains(&stage), "{}", run.stdout);
    }
    let length = format!("{:.2}", object["length_m"].as_f64().unwrap());
    assert!(
        words.contains(&length.as_str()),
        "no {length} in {}",
        run.stdout
    );
}

#[test]
fn the_distance_to_keep_can_be_given() {
    let place = Workplace::new();
    let clearance = |radius: &str| {
        let (status, object) = place.json(&format!("{ENDS} --radius {radius}"));
        assert_eq!(status, 0);
        object["min_clearance_m"].as_f64().unwrap()
    };
    let (none, wide) = (clearance("0"), clearance("3"));
    assert!(none < 0.5 && wide >= 3.0, "{none} and {wide}");
}

#[test]
fn a_walled_off_goal_is_an_answer() {
    let place = Workplace::new();
    place.write("halves.txt", HALVES);
    let arguments = "plan --map halves.txt --start 2,2 --goal 10,2 --radius 0.2";
    let (status, object) = place.json(arguments);
    assert_eq!(status, 1);
    assert_eq!(
        (&object["found"], &object["path"]),
        (&json!(false), &json!([]))
    );
    assert_eq!(object["error"], "NO_VALID_PATH");
    assert_fields(&object, "reason text, expanded whole, length_m null");
    let run = place.run(arguments);
    assert_eq!((run.status, run.stdout.lines().count()), (1, 1), "{run:?}");
    assert!(
        run.stdout.starts_with("NO_VALID_PATH: ") && run.stdout.contains("choose"),
        "{run:?}"
    );
}

#[test]
fn start_and_goal_may_be_one() {
    let (status, object) = Workplace::new().json("plan --map mine.yaml --start 10,5 --goal 10,5");
    assert_eq!((status, &object["found"]), (0, &json!(true)));
    assert_eq!(object["length_m"], 0.0);
    assert_eq!(object["path"].as_array().unwrap()[0], json!([10.0, 5.0]));
}

#[test]
fn unknown_ground_is_blocked_unless_it_is_said_to_be_free() {
    let place = Workplace::new();
    place.write("half_known.txt", "....???\n....???\n....???\n");
    let arguments = "plan --map half_known.txt --start 1.5,1.5 --goal 5.5,1.5 --radius 0.4";
    let refusal = place.refusal(arguments);
    assert!(
        refusal.contains("GOAL_OCCUPIED") && refusal.contains("--unknown free"),
        "{refusal}"
    );
    let (status, _) = place.json(&format!("{arguments} --unknown free"));
    assert_eq!(status, 0);
    place.write("bold.toml", "unknown = \"free\"\n");
    assert_eq!(place.json(&format!("{arguments} --config bold.toml")).0, 0);
    let refusal = place.refusal(&format!("{arguments} --config bold.toml --unknown blocked"));
    assert!(refusal.contains("GOAL_OCCUPIED"), "{refusal}");
}

#[test]
fn a_reader_that_stops_reading_is_no_fault() {
    let place = Workplace::new();
    let mut child = std::process::Command::new(assert_cmd::cargo::cargo_bin!("inbye"))
        .args(ENDS.split_whitespace())
        .arg("--json")
        .current_dir(place.path(""))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("the program ends");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!((output.status.code(), &*stderr), (Some(0), ""));
}

#[test]
fn every_kind_of_map_is_read() {
    let place = Workplace::new();
    place.write(
        "room.map",
        "type octile\nheight 3\nwidth 5\nmap\n.....\n.@@@.\n.....\n",
    );
    let (status, object) =
        place.json("plan --map room.map --resolution 2 --start 1,1 --goal 9,1 --radius 0");
    assert_eq!(status, 0);
    let raw: &Value = &object["raw"]["length_m"];
    assert!((raw.as_f64().unwrap() - 8.0).abs() < 1e-9, "{object}");
}
