//! `inbye evaluate`, compared with arithmetic by hand.

use crate::support::room;
use serde_json::{Value, json};

use super::program::{Workplace, assert_fields};

/// Clearances have a resolution of at most 0.25 mm, end poses of a sixteenth of that.
const TOLERANCE: f64 = 1e-3;

/// A room of 41 by 41 cells of 0.1 m with the robot in the centre; three speeds and three turn rates.
pub(super) fn room() -> Value {
    json!({
        "map": {"resolution_m": 0.1, "rows": room::rows(41, 41, &[])},
        "robot": {"pose": [2.05, 2.05, 0.0], "velocity": [0.2, 0.0],
                  "footprint": [{"x": 0.0, "y": 0.0, "radius": 0.1}]},
        "limits": {"min_vel_x": 0.0, "max_vel_x": 1.0, "max_vel_theta": 1.0, "acc_lim_x": 0.5,
                   "decel_lim_x": -0.5, "acc_lim_theta": 1.0, "decel_lim_theta": -1.0},
        "vx_samples": 3, "vtheta_samples": 3,
        "control_period_s": 0.1, "sim_time_s": 1.0, "sim_step_s": 0.1,
        "max_clearance_m": 3.0,
        "target": [3.55, 2.05], "key_node": [2.30, 2.05],
        "weights": {"heading": 0.1, "clearance": 0.2, "velocity": 0.3, "path": 0.4}
    })
}

#[track_caller]
fn evaluate(problem: &Value) -> (i32, Value) {
    let place = Workplace::new();
    place.write("problem.json", problem.to_string());
    place.json("evaluate --problem problem.json --engine cpu --samples")
}

#[track_caller]
fn assert_close(found: &Value, expected: f64) {
    let number = found.as_f64().unwrap_or(f64::NAN);
    assert!((number - expected).abs() < TOLERANCE, "{number} is not {expected}");
}

#[test]
fn evaluate_json_has_every_field() {
    let (status, object) = evaluate(&room());
    assert_eq!(status, 0);
    assert_fields(
        &object,
        "winner.index whole, winner.vx real, winner.vtheta real, winner.heading real, winner.clearance real, \
         winner.velocity real, winner.path real, winner.score real, admissible whole, rejected.collision whole, \
         rejected.cannot_stop whole, rejected.outside whole, sums.heading real, sums.clearance real, sums.velocity real, \
         sums.path real, digest text, samples list, samples[].index whole, samples[].vx real, \
         samples[].vtheta real, samples[].admissible bool, samples[].status text, samples[].end list, \
         samples[].heading real, samples[].clearance real, samples[].velocity real, samples[].path real, \
         samples[].score real",
    );
}

#[test]
fn problem_may_begin_with_a_byte_order_mark() {
    let place = Workplace::new();
    place.write("problem.json", format!("\u{feff}{}", room()));
    assert_eq!(place.json("evaluate --problem problem.json --engine cpu").0, 0);
}

#[test]
fn samples_have_documented_order_end_and_terms() {
    let (_, object) = evaluate(&room());
    let samples = object["samples"].as_array().unwrap();
    assert_eq!((samples.len(), &object["admissible"]), (9, &json!(9)));
    // 0.2 m/s +- 0.5 m/s^2 for 0.1 s; 0 +- 1 rad/s^2.
    for (index, sample) in samples.iter().enumerate() {
        let (v, omega) = ([0.15, 0.2, 0.25][index % 3], [-0.1, 0.0, 0.1][index / 3]);
        assert_eq!((&sample["index"], &sample["status"]), (&json!(index), &json!("ok")));
        assert_close(&sample["vx"], v);
        assert_close(&sample["vtheta"], omega);
        assert_close(&sample["velocity"], v);
        // Ten steps of 0.1 s, each straight along the heading at its start.
        let along = |part: fn(f64) -> f64| -> f64 {
            (0..10).map(|step| v * 0.1 * part(omega * 0.1 * f64::from(step))).sum()
        };
        let (x, y) = (along(libm::cos), along(libm::sin));
        assert_close(&sample["end"][0], 2.05 + x);
        assert_close(&sample["end"][1], 2.05 + y);
        assert_close(&sample["end"][2], omega);
        // The target lies 1.5 m, the key node 0.25 m ahead of the start.
        let bearing = libm::atan2(-y, 1.5 - x);
        assert_close(&sample["heading"], core::f64::consts::PI - (bearing - omega).abs());
        assert_close(&sample["path"], libm::hypot(0.25 - x, y));
    }
    // Sample 4 ends in the cell about (2.25, 2.05); the wall's cells are about x 4.05.
    assert_close(&samples[4]["clearance"], 4.05 - 2.25 - 0.1);
}

#[test]
fn winner_has_best_score_of_equation_35() {
    let (_, object) = evaluate(&room());
    let samples = object["samples"].as_array().unwrap();
    let terms = [("heading", 0.1), ("clearance", 0.2), ("velocity", 0.3), ("path", -0.4)];
    let sum = |term: &str| samples.iter().map(|sample| sample[term].as_f64().unwrap()).sum::<f64>();
    for (term, _) in terms {
        assert_close(&object["sums"][term], sum(term));
    }
    let score = |sample: &Value| -> f64 {
        terms.iter().map(|(term, weight)| weight * sample[term].as_f64().unwrap() / sum(term)).sum()
    };
    for sample in samples {
        assert!((sample["score"].as_f64().unwrap() - score(sample)).abs() < 1e-5, "{sample}");
    }
    // Straight to the target at the highest speed, through the key node.
    let winner = &object["winner"];
    assert_eq!(winner["index"], 5);
    assert_close(&winner["vx"], 0.25);
    assert_close(&winner["path"], 0.0);
    assert!(samples.iter().all(|sample| score(sample) <= score(&samples[5])));
    assert_eq!(winner["score"], samples[5]["score"]);
}

#[test]
fn every_kind_of_rejection_is_counted() {
    // A wall 0.5 m ahead of the robot's centre, all others far away; four speeds straight towards it for 0.4 s.
    let mut problem = room();
    let row = format!("{}#{}", ".".repeat(30), ".".repeat(10));
    problem["map"]["rows"] = json!(vec![row; 41]);
    problem["robot"]["pose"] = json!([2.55, 2.05, 0.0]);
    problem["robot"]["velocity"] = json!([0.5, 0.0]);
    problem["limits"]["acc_lim_x"] = json!(2.0);
    problem["limits"]["decel_lim_x"] = json!(-1.0);
    problem["limits"]["acc_lim_theta"] = json!(1e-9);
    problem["limits"]["decel_lim_theta"] = json!(-1e-9);
    problem["control_period_s"] = json!(0.2);
    problem["sim_time_s"] = json!(0.4);
    problem["vx_samples"] = json!(4);
    problem["vtheta_samples"] = json!(1);
    let (status, object) = evaluate(&problem);
    assert_eq!(status, 0);
    // The current speed is one of the four. Clearance at the end against the stopping distance v^2 / (2 * 1.0): 0.3 m and
    // 0.045 m at 0.3 m/s, 0.2 m and 0.125 m at 0.5 m/s, 0.1 m and 0.245 m at 0.7 m/s; at 0.9 m/s the robot ends in the cell
    // before the wall and hits it.
    let statuses: Vec<&str> = object["samples"]
        .as_array()
        .unwrap()
        .iter()
        .map(|sample| sample["status"].as_str().unwrap())
        .collect();
    assert_eq!(statuses, ["ok", "ok", "cannot_stop", "collision"], "{object}");
    assert_eq!(object["admissible"], 2);
    assert_eq!(object["rejected"], json!({"collision": 1, "cannot_stop": 1, "outside": 0}));
    assert_eq!(object["samples"][3]["score"], Value::Null);
    assert_eq!(object["samples"][3]["admissible"], false);
    assert_close(&object["samples"][1]["clearance"], 0.2);

    // The same speeds from 0.3 m before the map's far side: 0.9 m/s leaves it, unless the outside is free.
    problem["robot"]["pose"] = json!([3.8, 2.05, 0.0]);
    let (_, object) = evaluate(&problem);
    assert_eq!(
        object["rejected"],
        json!({"collision": 0, "cannot_stop": 0, "outside": 1}),
        "{object}"
    );
    problem["outside"] = json!("free");
    let (_, object) = evaluate(&problem);
    assert_eq!(object["admissible"], 4, "{object}");
}

#[test]
fn missing_admissible_sample_is_an_answer() {
    let mut problem = room();
    problem["robot"]["pose"] = json!([0.05, 0.05, 0.0]);
    let (status, object) = evaluate(&problem);
    assert_eq!((status, &object["winner"]), (1, &Value::Null));
    assert_eq!((&object["admissible"], &object["rejected"]["collision"]), (&json!(0), &json!(9)));
    let place = Workplace::new();
    place.write("problem.json", problem.to_string());
    let run = place.run("evaluate --problem problem.json");
    assert_eq!(run.status, 1, "{run:?}");
    assert!(run.stdout.starts_with("no sample is admissible: stop\n"), "{run:?}");
}

#[test]
fn moving_obstacle_collides_only_in_its_time() {
    // It crosses the robot's path 0.2 m ahead: at once, or long after the horizon of 1 s.
    let mut problem = room();
    problem["obstacles"] = json!([{"x": 2.25, "y": 2.05, "radius": 0.1, "vx": 0.0, "vy": 0.0}]);
    let (_, object) = evaluate(&problem);
    assert_eq!(object["rejected"]["collision"], 9, "{object}");
    problem["obstacles"][0]["y"] = json!(3.55);
    problem["obstacles"][0]["vy"] = json!(-0.5);
    let (_, object) = evaluate(&problem);
    assert_eq!(object["admissible"], 9, "{object}");
    // At 1 s it is at (2.25, 3.05), and sample 4 at (2.25, 2.05).
    assert_close(&object["samples"][4]["clearance"], 1.0 - 0.1 - 0.1);
}

#[test]
fn map_file_is_relative_to_problem_file() {
    let place = Workplace::new();
    let mut problem = room();
    let rows: Vec<String> = problem["map"]["rows"]
        .as_array()
        .unwrap()
        .iter()
        .map(|row| row.as_str().unwrap().to_owned() + "\n")
        .collect();
    place.write("deep/rows.json", problem.to_string());
    place.write("deep/room.txt", rows.concat());
    problem["map"] = json!({"file": "room.txt", "resolution_m": 0.1});
    place.write("deep/file.json", problem.to_string());
    let (status, from_rows) = place.json("evaluate --problem deep/rows.json --engine cpu");
    let (_, from_file) = place.json("evaluate --problem deep/file.json --engine cpu");
    assert_eq!(status, 0);
    assert_eq!(from_rows, from_file);
    assert!(from_rows.get("samples").is_none());
    // A file has its own place.
    problem["map"]["origin"] = json!([5.0, 5.0]);
    place.write("deep/moved.json", problem.to_string());
    let refusal = place.refusal("evaluate --problem deep/moved.json");
    assert!(refusal.contains("line 1: map.origin: it is only for map.rows"), "{refusal}");
}

#[test]
fn evaluate_text_lists_decision_and_samples() {
    let place = Workplace::new();
    place.write("problem.json", room().to_string());
    let run = place.run("evaluate --problem problem.json --engine cpu --samples");
    assert_eq!((run.status, run.errors.len()), (0, 0), "{run:?}");
    assert!(
        run.stdout.starts_with("command      vx 0.250 m/s, vtheta +0.000 rad/s (sample 5)\n"),
        "{}",
        run.stdout
    );
    let samples = run.stdout.lines().skip_while(|line| !line.starts_with("index ")).skip(1);
    assert_eq!(samples.count(), 9, "{}", run.stdout);
}

#[test]
fn picture_shows_sampled_and_chosen_trajectories() {
    let place = Workplace::new();
    let examples = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    let problem = examples.join("problem.json");
    let run =
        place.run(&format!("evaluate --problem {} --engine cpu --svg fan.svg", problem.display()));
    assert_eq!(run.status, 0, "{run:?}");
    let svg = std::fs::read_to_string(place.path("fan.svg")).expect("the picture is written");
    roxmltree::Document::parse(&svg).expect("the picture is XML");
    let count = |class: &str| svg.matches(&format!("<polyline class=\"{class}")).count();
    assert!(count("arc speed-") > 100 && count("chosen") == 1, "{} arcs", count("arc speed-"));
    assert!(svg.contains("1024 of 1024 samples are admissible"));
}
