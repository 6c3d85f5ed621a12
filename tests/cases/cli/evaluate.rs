//! `inbye evaluate`, against arithmetic done by hand.

use serde_json::{Value, json};

use super::program::{Workplace, assert_fields};

/// The clearance is measured in units of at most 0.25 mm, an end in sixteenths of it.
const TOLERANCE: f64 = 1e-3;

/// A room of 41 by 41 cells of 0.1 m, the robot in its middle, three speeds and three turn rates.
fn room() -> Value {
    let inside = format!("#{}#", ".".repeat(39));
    let mut rows = vec![inside; 41];
    rows[0] = "#".repeat(41);
    rows[40] = "#".repeat(41);
    json!({
        "map": {"resolution_m": 0.1, "rows": rows},
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
fn close(found: &Value, expected: f64) {
    let number = found.as_f64().unwrap_or(f64::NAN);
    assert!(
        (number - expected).abs() < TOLERANCE,
        "{number} is not {expected}"
    );
}

#[test]
fn the_object_has_every_field() {
    let (status, object) = evaluate(&room());
    assert_eq!(status, 0);
    assert_fields(
        &object,
        "winner.index whole, winner.v real, winner.omega real, winner.heading real, winner.dist real, \
         winner.vel real, winner.combine real, winner.score real, admissible whole, rejected.collision whole, \
         rejected.cannot_stop whole, rejected.outside whole, sums.heading real, sums.dist real, sums.vel real, \
         sums.combine real, digest text, samples list, samples[].index whole, samples[].v real, \
         samples[].omega real, samples[].admissible bool, samples[].reason text, samples[].end list, \
         samples[].heading real, samples[].dist real, samples[].vel real, samples[].combine real, \
         samples[].score real",
    );
}

#[test]
fn window_order_ends_and_terms_are_as_defined() {
    let (_, object) = evaluate(&room());
    let samples = object["samples"].as_array().unwrap();
    assert_eq!((samples.len(), &object["admissible"]), (9, &json!(9)));
    // 0.2 m/s and 0.5 m/s^2 for 0.1 s either way; 0 and 1 rad/s^2.
    for (index, sample) in samples.iter().enumerate() {
        let (v, omega) = ([0.15, 0.2, 0.25][index % 3], [-0.1, 0.0, 0.1][index / 3]);
        assert_eq!(
            (&sample["index"], &sample["reason"]),
            (&json!(index), &json!("ok"))
        );
        close(&sample["v"], v);
        close(&sample["omega"], omega);
        close(&sample["vel"], v);
        // Ten steps of 0.1 s, each straight along the heading at its beginning.
        let along = |part: fn(f64) -> f64| -> f64 {
            (0..10)
                .map(|step| v * 0.1 * part(omega * 0.1 * f64::from(step)))
                .sum()
        };
        let (x, y) = (along(libm::cos), along(libm::sin));
        close(&sample["end"][0], 2.05 + x);
        close(&sample["end"][1], 2.05 + y);
        close(&sample["end"][2], omega);
        // The target lies 1.5 m, the key node 0.25 m ahead of the start.
        let bearing = libm::atan2(-y, 1.5 - x);
        close(
            &sample["heading"],
            core::f64::consts::PI - (bearing - omega).abs(),
        );
        close(&sample["combine"], libm::hypot(0.25 - x, y));
    }
    // Sample 4 ends in the cell about (2.25, 2.05); the wall's cells are about x 4.05.
    close(&samples[4]["dist"], 4.05 - 2.25 - 0.1);
}

#[test]
fn the_winner_has_the_best_score_of_equation_35() {
    let (_, object) = evaluate(&room());
    let samples = object["samples"].as_array().unwrap();
    let terms = [
        ("heading", 0.1),
        ("dist", 0.2),
        ("vel", 0.3),
        ("combine", -0.4),
    ];
    let sum = |term: &str| {
        samples
            .iter()
            .map(|sample| sample[term].as_f64().unwrap())
            .sum::<f64>()
    };
    for (term, _) in terms {
        close(&object["sums"][term], sum(term));
    }
    let score = |sample: &Value| -> f64 {
        terms
            .iter()
            .map(|(term, weight)| weight * sample[term].as_f64().unwrap() / sum(term))
            .sum()
    };
    for sample in samples {
        assert!(
            (sample["score"].as_f64().unwrap() - score(sample)).abs() < 1e-5,
            "{sample}"
        );
    }
    // Straight at the target, fastest, onto the key node.
    let winner = &object["winner"];
    assert_eq!(winner["index"], 5);
    close(&winner["v"], 0.25);
    close(&winner["combine"], 0.0);
    assert!(
        samples
            .iter()
            .all(|sample| score(sample) <= score(&samples[5]))
    );
    assert_eq!(winner["score"], samples[5]["score"]);
}

#[test]
fn each_kind_of_rejection_is_counted() {
    // A wall 0.5 m ahead of the robot's centre, all others far off; four speeds straight at it for 0.4 s.
    let mut problem = room();
    let row = format!("{}#{}", ".".repeat(30), ".".repeat(10));
    problem["map"]["rows"] = json!(vec![row; 41]);
    problem["robot"]["pose"] = json!([2.55, 2.05, 0.0]);
    problem["robot"]["velocity"] = json!([0.6, 0.0]);
    problem["limits"]["acc_lim_x"] = json!(1.5);
    problem["limits"]["decel_lim_x"] = json!(-1.5);
    problem["limits"]["acc_lim_theta"] = json!(1e-9);
    problem["limits"]["decel_lim_theta"] = json!(-1e-9);
    problem["control_period_s"] = json!(0.2);
    problem["sim_time_s"] = json!(0.4);
    problem["vx_samples"] = json!(4);
    problem["vtheta_samples"] = json!(1);
    let (status, object) = evaluate(&problem);
    assert_eq!(status, 0);
    // Clearance at the end, and what stopping takes, v^2 / (2 * 1.5): 0.3 m/s has 0.3 m for 0.03 m, 0.5 m/s 0.2 m for
    // 0.083 m, 0.7 m/s 0.1 m for 0.163 m; at 0.9 m/s the robot ends in the cell before the wall, and touches it.
    let reasons: Vec<&str> = object["samples"]
        .as_array()
        .unwrap()
        .iter()
        .map(|sample| sample["reason"].as_str().unwrap())
        .collect();
    assert_eq!(
        reasons,
        ["ok", "ok", "cannot_stop", "collision"],
        "{object}"
    );
    assert_eq!(object["admissible"], 2);
    assert_eq!(
        object["rejected"],
        json!({"collision": 1, "cannot_stop": 1, "outside": 0})
    );
    assert_eq!(object["samples"][3]["score"], Value::Null);
    assert_eq!(object["samples"][3]["admissible"], false);
    close(&object["samples"][1]["dist"], 0.2);

    // The same speeds from 0.3 m before the map's far side: 0.9 m/s leaves it, unless what lies beyond is free.
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
fn no_admissible_sample_is_an_answer() {
    let mut problem = room();
    problem["robot"]["pose"] = json!([0.05, 0.05, 0.0]);
    let (status, object) = evaluate(&problem);
    assert_eq!((status, &object["winner"]), (1, &Value::Null));
    assert_eq!(
        (&object["admissible"], &object["rejected"]["collision"]),
        (&json!(0), &json!(9))
    );
    let place = Workplace::new();
    place.write("problem.json", problem.to_string());
    let run = place.run("evaluate --problem problem.json");
    assert_eq!(run.status, 1, "{run:?}");
    assert!(
        run.stdout.starts_with("no sample is admissible: stop\n"),
        "{run:?}"
    );
}

#[test]
fn a_moving_obstacle_is_met_when_it_is_there() {
    // It crosses the robot's line 0.2 m ahead: at once, or long after the horizon of 1 s.
    let mut problem = room();
    problem["obstacles"] = json!([{"x": 2.25, "y": 2.05, "radius": 0.1, "vx": 0.0, "vy": 0.0}]);
    let (_, object) = evaluate(&problem);
    assert_eq!(object["rejected"]["collision"], 9, "{object}");
    problem["obstacles"][0]["y"] = json!(3.55);
    problem["obstacles"][0]["vy"] = json!(-0.5);
    let (_, object) = evaluate(&problem);
    assert_eq!(object["admissible"], 9, "{object}");
    // At 1 s it is at (2.25, 3.05), and sample 4 at (2.25, 2.05).
    close(&object["samples"][4]["dist"], 1.0 - 0.1 - 0.1);
}

#[test]
fn a_map_file_is_found_beside_the_problem() {
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
}

#[test]
fn people_read_the_decision_and_its_samples() {
    let place = Workplace::new();
    place.write("problem.json", room().to_string());
    let run = place.run("evaluate --problem problem.json --engine cpu --samples");
    assert_eq!((run.status, run.errors.len()), (0, 0), "{run:?}");
    assert!(
        run.stdout
            .starts_with("command      v 0.250 m/s, omega +0.000 rad/s (sample 5)\n"),
        "{}",
        run.stdout
    );
    let samples = run
        .stdout
        .lines()
        .skip_while(|line| !line.starts_with("index "))
        .skip(1);
    assert_eq!(samples.count(), 9, "{}", run.stdout);
}
