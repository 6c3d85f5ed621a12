//! `inbye plan`.

use std::process::Stdio;

use serde_json::{Value, json};

use super::program::{Workplace, assert_fields};

const ENDS: &str = "plan --map mine.yaml --start 10,5 --goal 80,40";

/// A room in two halves; each cell is 1 m.
const HALVES: &str = "#############\n#.....#.....#\n#.....#.....#\n#.....#.....#\n#############\n";

#[test]
fn plan_json_has_every_field() {
    let place = Workplace::new();
    let (status, object) = place.json(ENDS);
    assert_eq!(status, 0);
    assert_fields(
        &object,
        "found bool, path list, length_m real, turns whole, min_clearance_m real, expanded whole, exact bool, \
         raw.length_m real, raw.points whole, raw.turns whole, \
         pruned.length_m real, pruned.points whole, pruned.turns whole, \
         time_ms.search real, time_ms.prune real, time_ms.smooth real, time_ms.total real, \
         curvature.max_per_m real, curvature.min_radius_m real, curvature.sharp_turns whole, \
         curvature.limit_per_m real, curvature.within_limit_share real, curvature.slowest_speed_mps real, \
         legs list, legs[].from list, legs[].to list, legs[].length_m real, legs[].turns whole, \
         legs[].min_clearance_m real, legs[].expanded whole, legs[].time_ms.total real",
    );
    assert_eq!(object["found"], true);
    let legs = object["legs"].as_array().unwrap();
    assert_eq!(legs.len(), 1);
    for field in ["length_m", "turns", "min_clearance_m", "expanded", "time_ms"] {
        assert_eq!(legs[0][field], object[field], "{field}");
    }
    let path = object["path"].as_array().unwrap();
    assert_eq!((&path[0], &path[path.len() - 1]), (&json!([10.0, 5.0]), &json!([80.0, 40.0])));
    // The wall at 49.5 to 50.5 m ends at 50 m; no path is shorter than along its corner.
    let corner = libm::hypot(39.5, 45.0) + 1.0 + libm::hypot(29.5, 10.0);
    let length_m = object["length_m"].as_f64().unwrap();
    assert!(length_m > corner && length_m < corner * 1.1, "{length_m} over {corner}");
    assert!(object["raw"]["length_m"].as_f64().unwrap() >= length_m);
    // The circumscribed radius of the default robot is 0.42 m.
    assert!(object["min_clearance_m"].as_f64().unwrap() > 0.42);
}

#[test]
fn plan_text_has_same_numbers_as_json() {
    let place = Workplace::new();
    let (_, object) = place.json(ENDS);
    let run = place.run(ENDS);
    assert_eq!((run.status, run.errors.len()), (0, 0), "{run:?}");
    let words: Vec<&str> = run.stdout.split_whitespace().collect();
    let lines = ["searched", "pruned", "smoothed", "clearance", "curvature", "expanded,"];
    for stage in lines {
        assert!(words.contains(&stage), "{}", run.stdout);
    }
    let length = format!("{:.2}", object["length_m"].as_f64().unwrap());
    assert!(words.contains(&length.as_str()), "no {length} in {}", run.stdout);
}

#[test]
fn clearance_on_a_map_without_obstacles_is_no_number() {
    let place = Workplace::new();
    place.write("free.txt", "......\n......\n");
    let plan = "plan --map free.txt --start 0.5,0.5 --via 3.5,0.5 --goal 5.5,0.5 --radius 0";
    let run = place.run(plan);
    assert_eq!(run.status, 0, "{run:?}");
    assert!(run.stdout.contains("clearance no obstacle on the map"), "{run:?}");
    assert!(!run.stdout.contains("inf"), "{run:?}");
}

#[test]
fn radius_sets_clearance() {
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
fn unreachable_goal_is_an_answer() {
    let place = Workplace::new();
    place.write("halves.txt", HALVES);
    let arguments = "plan --map halves.txt --start 2,2 --goal 10,2 --radius 0.2";
    let (status, object) = place.json(arguments);
    assert_eq!(status, 1);
    assert_eq!((&object["found"], &object["path"]), (&json!(false), &json!([])));
    assert_fields(
        &object,
        "error.code text, error.message text, error.place null, error.hint text, expanded whole, length_m null, stop null, \
         nearest_reachable list",
    );
    assert_eq!(object["error"]["code"], "NO_VALID_PATH");
    // The centre of the cell nearest to the wall between the halves, at the clearance.
    let nearest = &object["nearest_reachable"];
    assert_eq!(*nearest, json!([4.5, 2.5]));
    let (status, there) =
        place.json("plan --map halves.txt --start 2,2 --goal 4.5,2.5 --radius 0.2");
    assert_eq!((status, &there["found"]), (0, &json!(true)));
    let run = place.run(arguments);
    assert_eq!((run.status, run.stdout.lines().count()), (1, 1), "{run:?}");
    assert!(
        run.stdout.starts_with("NO_VALID_PATH: ")
            && run.stdout.contains("nearest to the goal is (4.500, 2.500)")
            && run.stdout.contains("choose"),
        "{run:?}"
    );
}

#[test]
fn plan_with_stops_joins_its_legs() {
    let place = Workplace::new();
    let stops = ["10,5", "20,30", "60,50", "80,40"];
    let arguments = "plan --map mine.yaml --start 10,5 --via 20,30 --via 60,50 --goal 80,40";
    let (status, object) = place.json(arguments);
    assert_eq!((status, &object["found"]), (0, &json!(true)));
    let legs = object["legs"].as_array().unwrap();
    assert_eq!(legs.len(), 3);
    let mut path: Vec<Value> = Vec::new();
    for (leg, ends) in legs.iter().zip(stops.windows(2)) {
        let alone = format!("plan --map mine.yaml --start {} --goal {}", ends[0], ends[1]);
        let (_, alone) = place.json(&alone);
        for field in ["length_m", "turns", "min_clearance_m", "expanded"] {
            assert_eq!(leg[field], alone[field], "{field} from {}", ends[0]);
        }
        let points = alone["path"].as_array().unwrap();
        assert_eq!((&leg["from"], &leg["to"]), (&points[0], &points[points.len() - 1]));
        path.extend_from_slice(&points[usize::from(!path.is_empty())..]);
    }
    assert_eq!(object["path"], json!(path));
    let sum = |field: &str| -> f64 { legs.iter().map(|leg| leg[field].as_f64().unwrap()).sum() };
    for field in ["length_m", "expanded"] {
        let whole = object[field].as_f64().unwrap();
        assert!((sum(field) - whole).abs() < 1e-9, "{field}: {whole}");
    }
    let time = |of: &Value| of["time_ms"]["total"].as_f64().unwrap();
    assert!((legs.iter().map(time).sum::<f64>() - time(&object)).abs() < 1e-6);
    let clearances = legs.iter().map(|leg| leg["min_clearance_m"].as_f64().unwrap());
    let least = clearances.fold(f64::INFINITY, f64::min);
    assert_eq!(object["min_clearance_m"].as_f64(), Some(least));
    // The turns at the stops are sharp turns of the whole path, but of no leg.
    assert_eq!(object["curvature"]["sharp_turns"], 2);
    assert_eq!(object["curvature"]["slowest_speed_mps"], 0.0);

    let run = place.run(arguments);
    let table: Vec<&str> = run.stdout.lines().skip_while(|line| !line.is_empty()).collect();
    assert_eq!((run.status, table.len()), (0, 5), "{}", run.stdout);
    for (line, stop) in
        table[2..].iter().zip(["(20.00, 30.00)", "(60.00, 50.00)", "(80.00, 40.00)"])
    {
        assert!(line.contains(stop), "no {stop} in {line}");
    }
    assert!(!place.run(ENDS).stdout.contains("leg"));
}

#[test]
fn failed_leg_is_named_by_its_stop() {
    let place = Workplace::new();
    place.write("halves.txt", HALVES);
    let map = "plan --map halves.txt --start 2,2 --radius 0.2";
    for (stops, stop) in
        [("--via 3,2 --via 10,2 --goal 4,2", "stop 2 of --via"), ("--via 3,2 --goal 10,2", "goal")]
    {
        let (status, object) = place.json(&format!("{map} {stops}"));
        assert_eq!((status, &object["stop"]), (1, &json!(stop)));
        assert_fields(&object, "nearest_reachable list, found bool");
        let run = place.run(&format!("{map} {stops}"));
        let expected = format!("{stop}: NO_VALID_PATH: ");
        assert!(run.stdout.starts_with(&expected), "{run:?}");
    }
    let refusal = place.refusal(&format!("{map} --via 3,2 --via 6,2 --goal 4,2"));
    assert!(
        refusal.contains("halves.txt: stop 2 of --via: GOAL_OCCUPIED: ")
            && refusal.contains("nearest free"),
        "{refusal}"
    );
    let refusal = place.refusal(&format!("{map} --via 3 --goal 4,2"));
    assert!(refusal.contains("--via") && refusal.contains("X,Y"), "{refusal}");
}

#[test]
fn curvature_is_compared_with_robot_limits() {
    let place = Workplace::new();
    let figure = |arguments: &str, name: &str| {
        let (status, object) = place.json(arguments);
        assert_eq!(status, 0, "{arguments}");
        object["curvature"][name].as_f64().unwrap()
    };
    let (tightest, limit) = (figure(ENDS, "max_per_m"), figure(ENDS, "limit_per_m"));
    assert!((figure(ENDS, "min_radius_m") * tightest - 1.0).abs() < 1e-12);
    // 1 rad/s at 1 m/s; the path is tighter at the end of the wall.
    assert!((limit - 1.0).abs() < 1e-12 && tightest > limit, "{tightest}");
    let share = figure(ENDS, "within_limit_share");
    assert!(share > 0.9 && share < 1.0, "{share}");
    let slowest = figure(ENDS, "slowest_speed_mps");
    assert!((slowest - 1.0 / tightest).abs() < 1e-9, "{slowest}");
    // A base that turns faster follows the whole path at its highest speed.
    place.write("agile.toml", "[robot]\nlimits = { max_vel_x = 0.5, max_vel_theta = 10.0 }\n");
    let agile = format!("{ENDS} --config agile.toml");
    assert_eq!(figure(&agile, "within_limit_share"), 1.0);
    assert_eq!(figure(&agile, "slowest_speed_mps"), 0.5);
    // Degree 1 does not smooth.
    place.write("sharp.toml", "[global]\nspline_degree = 1\n");
    let sharp = format!("{ENDS} --config sharp.toml");
    assert!(figure(&sharp, "sharp_turns") >= 1.0);
    assert_eq!(figure(&sharp, "max_per_m"), 0.0);
    assert_eq!(figure(&sharp, "slowest_speed_mps"), 0.0);
}

#[test]
fn start_may_equal_goal() {
    let (status, object) = Workplace::new().json("plan --map mine.yaml --start 10,5 --goal 10,5");
    assert_eq!((status, &object["found"]), (0, &json!(true)));
    assert_eq!(object["length_m"], 0.0);
    assert_eq!(object["path"].as_array().unwrap()[0], json!([10.0, 5.0]));
}

#[test]
fn unknown_cells_are_blocked_by_default() {
    let place = Workplace::new();
    place.write("half_known.txt", "....???\n....???\n....???\n");
    let arguments = "plan --map half_known.txt --start 1.5,1.5 --goal 5.5,1.5 --radius 0.4";
    let refusal = place.refusal(arguments);
    assert!(refusal.contains("GOAL_OCCUPIED") && refusal.contains("--unknown free"), "{refusal}");
    let (status, found) = place.json(&format!("{arguments} --unknown free"));
    assert_eq!(found["unknown"]["counted_as"], "free");
    assert!(found["unknown"]["cells"].as_u64() > Some(0), "{found}");
    assert_eq!(status, 0);
    place.write("bold.toml", "unknown = \"free\"\n");
    assert_eq!(place.json(&format!("{arguments} --config bold.toml")).0, 0);
    let refusal = place.refusal(&format!("{arguments} --config bold.toml --unknown blocked"));
    assert!(refusal.contains("GOAL_OCCUPIED"), "{refusal}");
}

#[test]
fn closed_pipe_is_no_error() {
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
fn movingai_map_is_read() {
    let place = Workplace::new();
    place.write("room.map", "type octile\nheight 3\nwidth 5\nmap\n.....\n.@@@.\n.....\n");
    let (status, object) =
        place.json("plan --map room.map --resolution 2 --start 1,1 --goal 9,1 --radius 0");
    assert_eq!(status, 0);
    let raw: &Value = &object["raw"]["length_m"];
    assert!((raw.as_f64().unwrap() - 8.0).abs() < 1e-9, "{object}");
}

#[test]
fn search_is_selectable_and_states_exactness() {
    let place = Workplace::new();
    let raw_m = |config: &str| {
        place.write("search.toml", config);
        let (status, object) = place.json(&format!("{ENDS} --config search.toml"));
        assert_eq!(status, 0, "{config}");
        let exact = object["exact"].as_bool().unwrap();
        (exact, object["raw"]["length_m"].as_f64().unwrap())
    };
    let (exact, shortest_m) = raw_m("[global]\nsearch = \"jump_points\"\n");
    assert!(exact);
    let (exact, octile_m) = raw_m("[global]\nheuristic = \"octile\"\n");
    assert!(exact && (octile_m - shortest_m).abs() < 1e-9);
    let (exact, default_m) = raw_m("");
    assert!(!exact && default_m >= shortest_m - 1e-9);
    let (_, careful_m) = raw_m("[global]\nclearance_weight = 5.0\npreferred_clearance_m = 4.0\n");
    assert!(careful_m > shortest_m);
    let both = "[global]\nsearch = \"jump_points\"\nclearance_weight = 5.0\n";
    place.write("search.toml", both);
    let refusal = place.refusal(&format!("{ENDS} --config search.toml"));
    assert!(refusal.contains("clearance_weight is 5"), "{refusal}");
}
