//! Unusable problems of `evaluate`: one line with the file, the place and the cure; exit status 2.

use serde_json::{Value, json};

use super::program::Workplace;
use super::unusable_input::place;

/// A problem with a speed limit out of range in its fourth line.
const LIMITS: &str = r#"{"map": {"resolution_m": 0.5, "rows": ["...."]},
"robot": {"pose": [0.2, 0.2, 0]}, "target": [1, 0],
"limits": {
  "max_vel_x": 99}}"#;

/// A sound problem, in which one thing at a time is made wrong.
pub(super) fn problem() -> Value {
    json!({
        "map": {"resolution_m": 0.5, "origin": [0.0, 0.0], "rows": ["................"]},
        "robot": {"pose": [0.25, 0.25, 0.0], "footprint": [{"x": 0.0, "y": 0.0, "radius": 0.1}]},
        "limits": {"max_vel_x": 1.0},
        "obstacles": [{"x": 3.0, "y": 0.0, "radius": 0.1}],
        "target": [1.0, 0.0],
        "weights": {"path": 0.1},
        "sim_time_s": 1.0
    })
}

#[test]
fn unusable_problem_values_are_rejected() {
    let place = place();
    place.write("problem.json", problem().to_string());
    assert_eq!(
        place.json("evaluate --problem problem.json").0,
        0,
        "the problem is valid before the change"
    );
    let table = r#"
/vx_samples 0 -> line 1: vx_samples is 0; at least 1
/vtheta_samples 0 -> vtheta_samples is 0; at least 1
/vx_samples -1 -> line 1; "vx_samples":-1; expected a whole number
/vx_samples 1.5 -> "vx_samples":1.5; expected a whole number
/vx_samples "many" -> "vx_samples":"many"; expected a whole number
/vx_samples 4000000000 -> vx_samples; 1 to 4194304
/control_period_s 0 -> control_period_s is 0; 0.0001 to 1000
/control_period_s 1e300 -> control_period_s is 1e300; 0.0001 to 1000
/sim_time_s -1 -> sim_time_s is -1; above zero
/sim_time_s 500 -> sim_time_s; steps; 1 to 1023
/sim_step_s 0 -> sim_step_s is 0; above zero
/max_clearance_m 0 -> max_clearance_m is 0; above zero
/max_clearance_m 900 -> max_clearance_m is 900; at most 11
/outside "wall" -> `wall`; `obstacle`; `free`
/normalization "mean" -> `mean`; `sum`; `minmax`
/stopping "never" -> `never`; `clearance`; `arc`
/unknown "perhaps" -> `perhaps`; `blocked`; `free`
/target [1] -> "target":[1]; length 2
/target [5000,0] -> distance to the target; at most
/target [1e300,0] -> distance to the target; at most
/key_node [5000,0] -> distance to the key node; at most
/key_node "x" -> "key_node":"x"; length 2
/weights/heading -1 -> heading is -1; 0 to 1e6
/weights/pth 1 -> unknown field `pth`; did you mean `path`?
/limits/max_vel 1 -> unknown field `max_vel`; did you mean `max_vel_x`?
/limits/max_vel_x -1 -> [limits] max_vel_x is -1; 0 to 15.99
/limits/min_vel_x 0.1 -> [limits] min_vel_x is 0.1; -15.99 to 0
/limits/max_vel_theta 0 -> [limits] max_vel_theta is 0; above zero
/limits/acc_lim_x 0 -> [limits] acc_lim_x is 0; above zero
/limits/decel_lim_x 0.5 -> [limits] decel_lim_x is 0.5; below zero
/robot/pose [0,0] -> "pose":[0,0]; length 2; 3 numbers
/robot/pose [1e300,0,0] -> distance; at most
/robot/pose [1,1,1e300] -> yaw is 1e300 rad; at most 1e9 rad
/robot/velocity [1] -> "velocity":[1]; length 2
/robot/footprint [] -> no disc; at least one
/robot/footprint [{"x":0,"y":0,"radius":-1}] -> disc 0; radius above zero
/robot/footprint [{"x":0,"y":0}] -> missing field `radius`
/robot/footprint [{"x":99,"y":0,"radius":1}] -> disc offset; at most
/robot/footprint [{"x":0,"y":0,"radius":1e300}] -> disc radius; at most
/obstacles [{"x":0,"y":0,"radius":0}] -> moving obstacle 0; radius above zero
/obstacles [{"x":0,"y":0,"radius":1,"vx":1e300}] -> moving obstacle; at most
/map/resolution_m 0 -> map.rows: resolution is 0; above zero
/map/resolution_m -1 -> map.rows: resolution is -1; above zero
/map/resolution_m 5 -> map resolution is 5 m; 0.001 to 2 m
/map/resolution_m null -> map.resolution_m
/map/origin [1] -> map.origin; [x, y, yaw]
/map/origin [1e300,0] -> at most
/map/rows [] -> map.rows; holds no cell
/map/rows ["..","."] -> map.rows: row 2; equally long
/map/rows ["x"] -> map.rows: row 1, column 1; 'x'
/map {} -> map; `rows`; `file`
/map {"file":"gone.yaml"} -> gone.yaml; check the path
/map {"file":"mine.yaml","resolution_m":0.1} -> map.resolution_m: mine.yaml states its own
/map {"file":"mine.yaml","rows":["."]} -> map; `rows`; `file`
/colour 1 -> unknown field `colour`; `target`
/vx_sample 1 -> did you mean `vx_samples`?
"#;
    for line in table.lines().filter(|line| !line.is_empty()) {
        let (change, words) = line.split_once(" -> ").expect("a line has an arrow");
        let (pointer, value) = change.split_once(' ').expect("a change has a value");
        let (parent, key) = pointer.rsplit_once('/').expect("a pointer has a slash");
        let mut changed = problem();
        let parent = changed.pointer_mut(parent).expect("the parent is there");
        parent[key] = serde_json::from_str(value).expect("the value is JSON");
        place.write("changed.json", changed.to_string());
        assert_error(&place, "changed.json", change, words);
    }
}

#[test]
fn unusable_problem_files_are_rejected() {
    let place = place();
    let with_list = LIMITS.replace("\n  \"max_vel_x\": 99}}", "}, \"weights\": [1, 2, 3, 4]}");
    for (text, words) in [
        ("", "it is empty: write an object with map, robot and target"),
        ("{", "line 1"),
        (&with_list, "line 3; a table of keys and values"),
        ("[]", "expected an object with map, robot and target"),
        ("{\"map\": NaN}", "line 1"),
        ("{\"target\": [1e999, 0]}", "line 1; out of range"),
        ("{\n\"target\": [1, 0]\n}", "line 3; missing field `map`"),
        (LIMITS, "line 4: [limits] max_vel_x is 99"),
    ] {
        place.write("no.json", text);
        assert_error(&place, "no.json", text, words);
    }
    for file in ["gone.json", "."] {
        let refusal = place.refusal(&format!("evaluate --problem {file}"));
        assert!(refusal.contains(&format!("--problem {file}: cannot be read")), "{refusal}");
    }
}

#[track_caller]
fn assert_error(place: &Workplace, file: &str, what: &str, words: &str) {
    let refusal = place.refusal(&format!("evaluate --problem {file} --engine cpu"));
    assert!(refusal.contains(file), "{what}: {refusal}");
    for word in words.split("; ") {
        assert!(refusal.contains(word), "{what}: no {word:?} in: {refusal}");
    }
}
