//! `inbye drive`.

use std::fs;

use crate::support::room;
use serde_json::{Value, json};

use super::program::{Workplace, assert_fields};

/// A room of 12 by 5.2 m with 0.2 m cells and a pillar between start and goal.
fn room() -> Workplace {
    let place = Workplace::new();
    place.write("room.txt", room::rows(60, 26, &[(28..31, 11..15)]).join("\n"));
    place
}

const DRIVE: &str =
    "drive --map room.txt --resolution 0.2 --start 1.5,2.5 --goal 10.5,2.5 --engine cpu";

#[track_caller]
fn digest(object: &Value) -> &str {
    let digest = object["trace_digest"].as_str().expect("a digest is text");
    assert_eq!(digest.len(), 64, "{digest}");
    digest
}

#[test]
fn drive_reaches_goal_and_json_has_every_field() {
    let place = room();
    let (status, object) = place.json(DRIVE);
    assert_eq!(status, 0);
    assert_fields(
        &object,
        "reached bool, collided bool, time_s real, travelled_m real, min_clearance_m real, \
         final_error.x_m real, final_error.y_m real, final_error.yaw_rad null, engine text, \
         latency_ms.p50 real, latency_ms.p99 real, latency_ms.max real, ticks whole, trace_digest text, \
         gpu_losses null, gpu_reopened null, gpu_incidents null, cpu_ticks null, deadline null",
    );
    assert_eq!((&object["reached"], &object["collided"]), (&json!(true), &json!(false)));
    let number = |name: &str| object[name].as_f64().unwrap();
    // Nine metres at 1 m/s at most, less the goal tolerance of 0.25 m.
    assert!(number("travelled_m") > 8.7 && number("travelled_m") < 12.0, "{object}");
    assert!(number("time_s") > 8.7 && number("min_clearance_m") > 0.0, "{object}");
    let error = |axis: &str| object["final_error"][axis].as_f64().unwrap();
    assert!(libm::hypot(error("x_m"), error("y_m")) <= 0.25, "{object}");
    let periods = number("time_s") / 0.1;
    assert!((number("ticks") - 1.0 - periods).abs() < 1e-6, "{object}");
    assert!(object["engine"].as_str().unwrap().starts_with("CPU"), "{object}");
}

#[test]
fn digest_is_equal_for_equal_seed_and_any_threads() {
    let place = room();
    let run = |more: &str| place.json(&format!("{DRIVE} --obstacles 1 --time-limit 8 {more}")).1;
    let first = run("--seed 5");
    assert_eq!(digest(&first), digest(&run("--seed 5")));
    assert_eq!(digest(&first), digest(&run("--seed 5 --threads 1")));
    assert_eq!(digest(&first), digest(&run("--seed 5 --threads 2")));
    assert_ne!(digest(&first), digest(&run("--seed 6")));
}

#[test]
fn goal_yaw_is_reached() {
    let arguments = DRIVE.replace("10.5,2.5", "4.5,2.5,-1.5");
    let (status, object) = room().json(&arguments);
    assert_eq!(status, 0);
    let error = object["final_error"]["yaw_rad"].as_f64().expect("a yaw error");
    assert!(error.abs() <= 0.1, "{object}");
}

#[test]
fn report_and_record_are_written() {
    let place = room();
    let run = place.run(&format!("{DRIVE} --report out/page --record trace.jsonl"));
    assert_eq!(run.status, 0, "{run:?}");
    assert!(run.stdout.contains("reached the goal"), "{run:?}");
    let page = fs::read_to_string(place.path("out/page/index.html")).expect("the report is there");
    assert!(page.contains("<svg") && page.contains("room.txt"));
    let record = fs::read_to_string(place.path("trace.jsonl")).expect("the record is there");
    let (_, object) = place.json(DRIVE);
    assert_eq!(record.lines().count() as u64, object["ticks"].as_u64().unwrap());
    for line in record.lines() {
        let tick: Value = serde_json::from_str(line).expect("each line is JSON");
        assert_fields(&tick, "time_s real, pose list, gap_m real, mode text");
    }
}

#[test]
fn drive_text_states_outcome() {
    let place = room();
    let run = place.run(&format!("{DRIVE} --time-limit 2"));
    assert_eq!(run.status, 1, "{run:?}");
    assert!(run.stdout.starts_with("did not reach the goal: "), "{run:?}");
    assert_eq!(run.engine_note.as_deref().map(|note| note.contains("requested")), Some(true));
    let auto = place.run(&DRIVE.replace("--engine cpu", "--engine auto --time-limit 0.1"));
    let note = auto.engine_note.expect("a note");
    assert!(note.contains("fastest for 20 x 40 arcs of 25 steps"), "{note}");
}

#[test]
fn directions_without_beams_are_no_blind_ones() {
    let place = Workplace::new();
    let lidar = "--set simulation.lidar.field_of_view_rad=4.712 --set simulation.lidar.beams=811";
    let drive = "drive --scene roadway --obstacles 0 --engine cpu --time-limit 5";
    let sweep = "--set simulation.lidar.sweep_s=0.025";
    let (_, object) = place.json(&format!("{drive} {lidar} {sweep}"));
    assert_eq!(object["observation_faults"], json!({}), "{object}");
}

#[test]
fn robot_with_unknown_start_finds_its_pose() {
    let place = Workplace::new();
    let drive = "drive --scene roadway --engine cpu --unknown-start";
    let (status, object) = place.json(&format!("{drive} --set pose_source=\"scans\""));
    assert_eq!((status, &object["reached"]), (0, &json!(true)), "{object}");
    let unknown = object["observation_faults"]["lost_no_pose"].as_u64();
    assert!(unknown.is_some_and(|ticks| (1..50).contains(&ticks)), "{object}");
    let refusal = place.refusal(drive);
    assert!(refusal.contains("pose_source"), "{refusal}");
}

/// The file of the times that `--engine auto` has measured here, as JSON.
fn measured(place: &Workplace) -> Value {
    let text = fs::read_to_string(place.path("inbye/engine-times.json")).expect("it is kept");
    serde_json::from_str(&text).expect("JSON")
}

#[test]
fn auto_measures_once_for_each_size() {
    let place = room();
    let short = DRIVE.replace("--engine cpu", "--time-limit 0.1");
    place.run(&short);
    let mut kept = measured(&place);
    assert_eq!(kept.as_array().map(Vec::len), Some(1), "{kept}");
    // The next command believes the file.
    kept[0]["times"] = json!([{ "name": "CPU, 3 threads", "threads": 3, "p50_ms": 0.001 }]);
    place.write("inbye/engine-times.json", kept.to_string());
    let note = place.run(&short).engine_note.expect("a note");
    assert!(note.contains("CPU, 3 threads") && note.contains("0.001 ms"), "{note}");
    assert_eq!(measured(&place), kept);
    place.write("dense.toml", "[local]\nvx_samples = 21\n");
    place.run(&format!("{short} --config dense.toml"));
    assert_eq!(measured(&place).as_array().map(Vec::len), Some(2));
    // A file that is damaged is measured again, without a word.
    place.write("inbye/engine-times.json", "[{");
    let run = place.run(&short);
    assert!(run.errors.is_empty(), "{run:?}");
    assert_eq!(measured(&place).as_array().map(Vec::len), Some(1));
}

#[test]
fn missing_gpu_is_counted_and_cpu_gives_same_digest() {
    let place = room();
    let cpu = place.json(DRIVE).1;
    let auto = place.json(&DRIVE.replace("--engine cpu", "")).1;
    assert_eq!(digest(&auto), digest(&cpu));
    // The GPU that was fastest when it was measured is missing now.
    let mut kept = measured(&place);
    kept[0]["times"] = json!([{ "name": "a GPU of yesterday", "threads": 0, "p50_ms": 0.001 }]);
    place.write("inbye/engine-times.json", kept.to_string());
    let auto = place.json(&DRIVE.replace("--engine cpu", "")).1;
    assert_eq!(digest(&auto), digest(&cpu));
    if cfg!(feature = "gpu") {
        assert_eq!(auto["gpu_losses"], json!({ "absent": 1 }));
        assert_eq!(auto["gpu_reopened"], json!(0));
        assert_eq!(auto["gpu_incidents"][0]["decision"], json!(0));
        assert!(auto["cpu_ticks"].as_u64() > Some(50), "{auto}");
    }
    fs::remove_file(place.path("inbye/engine-times.json")).expect("it is there");
    for engine in ["", "--engine cpu"] {
        let required = format!("{} --require-gpu", DRIVE.replace("--engine cpu", engine));
        let refusal = place.refusal(&required);
        assert!(refusal.contains("a GPU is required"), "{refusal}");
    }
}

#[test]
fn met_deadline_changes_nothing_and_missed_deadline_stands() {
    let place = room();
    let free = place.json(DRIVE).1;
    let kept = place.json(&format!("{DRIVE} --deadline 1e6")).1;
    assert_eq!(digest(&kept), digest(&free));
    assert_fields(
        &kept,
        "deadline.deadline_s real, deadline.decisions whole, deadline.misses whole, \
         deadline.lowest.vx_samples whole, deadline.last.vtheta_samples whole",
    );
    assert_eq!(kept["deadline"]["misses"], json!(0));
    let missed = format!("{DRIVE} --deadline 1e-6 --time-limit 3");
    let (status, object) = place.json(&missed);
    assert_eq!(status, 1);
    assert_eq!(object["travelled_m"], json!(0.0));
    let deadline = &object["deadline"];
    assert_eq!(deadline["misses"], deadline["decisions"]);
    assert_eq!(deadline["lowest"]["vtheta_samples"], json!(8));
    let words = place.run(&missed).stdout;
    assert!(words.contains("30 of 30 decisions took longer"), "{words}");
    let refusal = place.refusal(&format!("{DRIVE} --deadline 0"));
    assert!(refusal.contains("--deadline"), "{refusal}");
}

/// The robot is 0.7 m long and 0.5 m wide, and stands 0.32 m from the wall.
#[test]
fn start_with_the_body_in_a_wall_is_unusable_input() {
    let place = room();
    let drive = "drive --map room.txt --resolution 0.1 --engine cpu --goal 2.2,1.3 --start";
    let refusal = place.refusal(&format!("{drive} 1.5,0.42,1.571"));
    assert!(refusal.contains("START_OCCUPIED: start (1.50, 0.42) has no room"), "{refusal}");
    assert!(refusal.contains("with yaw 1.57: the nearest yaw that fits is "), "{refusal}");
    place.write(
        "plan.toml",
        "seeds = [0, 1]\n[[worlds]]\nkind = \"map\"\npath = \"room.txt\"\nresolution_m = 0.1\n\
         routes = [{ start = [1.5, 0.42, 1.571], goal = [2.2, 1.3] }]\n",
    );
    let refusal = place.refusal("sweep plan.toml --list");
    assert!(refusal.contains("room route 1: START_OCCUPIED: start (1.50, 0.42)"), "{refusal}");
}

#[test]
fn unreachable_goal_is_an_answer() {
    let place = room();
    let open = fs::read_to_string(place.path("room.txt")).unwrap();
    let cut = |row: &str| [&row[..40], "#", &row[41..], "\n"].concat();
    place.write("room.txt", open.lines().map(cut).collect::<Vec<_>>().concat());
    let (status, object) = place.json(DRIVE);
    assert_eq!(status, 1);
    assert_eq!((&object["reached"], &object["found"]), (&json!(false), &json!(false)));
    let error = &object["error"];
    assert_eq!((&error["code"], &error["place"]), (&json!("NO_VALID_PATH"), &Value::Null));
    assert!(error["hint"].as_str().is_some_and(|hint| hint.starts_with("choose ")), "{error}");
    assert_eq!([&object["fault"], &object["why"]], [&error["message"]; 2]);
    assert_eq!((&object["stop"], &object["interrupted"]), (&Value::Null, &json!(false)));
    let run = place.run(DRIVE);
    assert_eq!((run.status, run.stdout.lines().count()), (1, 1), "{run:?}");
    assert!(run.stdout.starts_with("NO_VALID_PATH: no path from "), "{run:?}");
    // The goal of the first leg that fails is an intermediate stop.
    let (_, object) = place.json(&format!("{DRIVE} --via 3,2.5 --via 10.5,1.5"));
    assert_eq!(object["stop"], "stop 2 of --via");
    let message = object["error"]["message"].as_str().expect("a message");
    assert!(message.starts_with("stop 2 of --via: NO_VALID_PATH: "), "{message}");
}

#[test]
fn unusable_stop_is_named() {
    let place = room();
    for (stops, expected) in [
        ("--via 3,2.5 --via 5.9,2.5", "stop 2 of --via: GOAL_OCCUPIED: goal (5.90, 2.50)"),
        ("--via 50,2.5 --obstacles 1", "stop 1 of --via: GOAL_OUTSIDE_MAP: goal (50.00, 2.50)"),
    ] {
        let refusal = place.refusal(&format!("{DRIVE} {stops}"));
        assert!(refusal.contains(&format!("room.txt: {expected}")), "{refusal}");
    }
}

#[test]
fn obstacles_are_a_number_or_a_file() {
    let place = room();
    place.write("far.json", r#"[{"x": 11.4, "y": 4.5, "radius": 0.2, "speed": 0.0}]"#);
    place.write("far.toml", "[[obstacles]]\nx = 11.4\ny = 4.5\nradius = 0.2\nspeed = 0.0\n");
    let (status, from_json) = place.json(&format!("{DRIVE} --obstacles far.json"));
    let (_, from_toml) = place.json(&format!("{DRIVE} --obstacles far.toml"));
    assert_eq!(status, 0, "{from_json}");
    assert_eq!(digest(&from_json), digest(&from_toml));
    assert_ne!(digest(&from_json), digest(&place.json(DRIVE).1));
    let crowd = place.json(&format!("{DRIVE} --time-limit 1 --obstacles 2")).1;
    assert_ne!(digest(&crowd), digest(&place.json(&format!("{DRIVE} --time-limit 1")).1));
}

/// The keys are those that the error of an unknown one lists.
#[test]
fn every_key_of_obstacle_files_is_in_the_book_and_in_the_example() {
    let place = room();
    place.write("key.json", r#"[{"none": 1}]"#);
    let refusal = place.refusal(&format!("{DRIVE} --obstacles key.json"));
    let (_, keys) = refusal.split_once("expected one of ").expect("the keys are listed");
    let keys: Vec<&str> = keys.split('`').skip(1).step_by(2).collect();
    assert_eq!(keys.len(), 12, "{keys:?}");
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let read = |file: &str| fs::read_to_string(root.join(file)).expect("a text of the repository");
    let (book, example) = (read("docs/src/cli.md"), read("examples/moving_obstacles.toml"));
    let (_, section) = book.split_once("\n### Moving obstacles\n").expect("the section");
    for key in keys {
        let is_row = |line: &str| line.starts_with('|') && line.contains(&format!("`{key}`"));
        assert!(section.lines().any(is_row), "{key} is in no row of the book");
        let is_set = |line: &str| line.starts_with(&format!("{key} = "));
        assert!(example.lines().any(is_set), "{key} is not in the example");
    }
}

/// The first obstacle appears later, and the robot has left by then.
#[test]
fn obstacle_that_touches_the_robot_at_its_start_is_unusable_input() {
    let place = room();
    let later = r#"{"x": 1.5, "y": 2.5, "radius": 0.3, "speed": 0.0, "appears_at_s": 60}"#;
    let at = |x: f64| {
        format!(r#"[{later},{}{{"x": {x}, "y": 2.5, "radius": 0.3, "speed": 0.0}}]"#, '\n')
    };
    place.write("in.json", at(2.1));
    let refusal = place.refusal(&format!("{DRIVE} --obstacles in.json"));
    let expected = "in.json: line 2: obstacle 1: touches the robot at its start (1.50, 2.50): move";
    assert!(refusal.contains(expected), "{refusal}");
    // The robot is 0.7 m long.
    place.write("next.json", at(2.2));
    let (_, object) = place.json(&format!("{DRIVE} --time-limit 1 --obstacles next.json"));
    assert_eq!(object["collided"], false, "{object}");
}

#[test]
fn configuration_changes_robot() {
    let place = room();
    place.write("slow.toml", "[robot.limits]\nmin_vel_x = 0.0\nmax_vel_x = 0.4\n");
    let (_, slow) = place.json(&format!("{DRIVE} --config slow.toml"));
    assert_eq!(slow["reached"], true);
    assert!(slow["time_s"].as_f64().unwrap() > 8.7 / 0.4, "{slow}");
}

#[test]
fn real_base_without_lidar_needs_an_explicit_flag() {
    let place = Workplace::new();
    let drive = "drive --map mine.yaml --start 5,5 --goal 7,5 --port no-such-port";
    let refusal = place.refusal(drive);
    assert!(refusal.contains("--lidar") && refusal.contains("--simulated-senses"), "{refusal}");
    let refusal = place.refusal(&format!("{drive} --simulated-senses --arm"));
    assert!(refusal.contains("no-such-port: cannot be opened"), "{refusal}");
}

#[test]
fn flags_of_a_real_base_are_not_ignored_in_a_simulation() {
    let place = room();
    place.write("truth.txt", fs::read(place.path("room.txt")).expect("the map is there"));
    // clap drops the requirement of a flag if the required one conflicts with another given flag.
    for simulated in ["", "--real-time-factor 50", "--truth truth.txt"] {
        for real in [
            "--lidar /dev/nope",
            "--simulated-senses",
            "--arm",
            "--operator-port 7777",
            "--operator --live 0",
            "--protocol wheeltec",
            "--base-config gone.toml",
        ] {
            let refusal = place.refusal(&format!("{DRIVE} {simulated} {real}"));
            assert!(refusal.contains("--port"), "{simulated} {real}: {refusal}");
        }
    }
}
