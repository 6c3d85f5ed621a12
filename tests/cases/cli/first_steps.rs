//! What a new user meets: scenes, single settings, typical mistakes, `doctor`, and Ctrl-C.

use serde_json::{Value, json};

use super::program::{Workplace, assert_fields};
use crate::support::room;

#[test]
fn scene_gives_map_start_and_goal() {
    let place = Workplace::new();
    let (status, plan) = place.json("plan --scene mine");
    assert_eq!((status, &plan["found"]), (0, &json!(true)));
    let ends = |plan: &Value| {
        let path = plan["path"].as_array().expect("a path");
        [path.first().cloned(), path.last().cloned()]
    };
    let [start, goal] = ends(&plan);
    assert_eq!((start, goal), (Some(json!([10.0, 5.0])), Some(json!([80.0, 40.0]))));
    let (_, other) = place.json("plan --scene mine --goal 60,31");
    assert_eq!(ends(&other)[1], Some(json!([60.0, 31.0])));
}

#[test]
fn scene_gives_pedestrians_and_seed() {
    let place = Workplace::new();
    let digest = |arguments: &str| {
        let (status, drive) =
            place.json(&format!("drive --scene dead_end --engine cpu {arguments}"));
        assert_eq!((status, &drive["reached"]), (0, &json!(true)), "{drive}");
        drive["trace_digest"].clone()
    };
    let by_default = digest("");
    assert_eq!(digest("--obstacles 4 --seed 7"), by_default);
    assert_ne!(digest("--obstacles 0"), by_default);
}

#[test]
fn scene_and_map_exclude_each_other_and_one_is_needed() {
    let place = Workplace::new();
    let both = place.refusal("plan --scene mine --map mine.yaml --start 1,1 --goal 2,2");
    assert!(both.contains("cannot be used with"), "{both}");
    let none = place.refusal("plan --start 1,1 --goal 2,2");
    assert!(none.contains("--map"), "{none}");
    let unknown = place.refusal("drive --scene moon");
    assert!(unknown.contains("roadway") && unknown.contains("mine"), "{unknown}");
    let without_ends = place.refusal("plan --map mine.yaml");
    assert!(without_ends.contains("--start") && without_ends.contains("--goal"), "{without_ends}");
}

#[test]
fn one_setting_is_changed_and_a_wrong_one_is_refused() {
    let place = Workplace::new();
    let changed =
        place.run("plan --scene dead_end --set local.vx_samples=32 --set local.normalization=sum");
    assert_eq!(changed.status, 0, "{changed:?}");
    let (_, wide) = place.json("plan --scene dead_end --set navigator.safety_margin_m=0.3");
    let (_, usual) = place.json("plan --scene dead_end");
    assert_ne!(wide["min_clearance_m"], usual["min_clearance_m"]);
    for (change, named) in [
        ("local.vx_sampels=3", "vx_samples"),
        ("local.vx_samples=1.5", "local.vx_samples = 1.5"),
        ("local.vx_samples", "KEY=VALUE"),
        ("local.normalization=most", "minmax"),
    ] {
        let error = place.refusal(&format!("plan --scene dead_end --set {change}"));
        assert!(error.contains(named), "{change}: {error}");
    }
}

#[test]
fn changes_of_set_are_checked_together() {
    let place = Workplace::new();
    // Each of these is out of range without the other, in any order.
    for [one, other] in [
        ["local.sim_step_s=5", "local.sim_time_s=6"],
        ["local.vx_samples=200000", "local.vtheta_samples=5"],
    ] {
        for [first, second] in [[one, other], [other, one]] {
            let run = place.run(&format!("plan --scene dead_end --set {first} --set {second}"));
            assert_eq!(run.status, 0, "{first} {second}: {run:?}");
        }
        let refusal = place.refusal(&format!("plan --scene dead_end --set {one}"));
        assert!(refusal.contains(&format!("--set {one}: ")), "{refusal}");
    }
    // Of one key the later counts.
    let twice = "plan --scene dead_end --set local.vx_samples=0 --set local.vx_samples=5";
    assert_eq!(place.run(twice).status, 0);
    // The flag with the failing key is named, wherever it is.
    let refusal = place.refusal(
        "plan --scene dead_end --set local.sim_time_s=-1 --set local.vx_samples=5 --set navigator.safety_margin_m=0.1",
    );
    assert!(refusal.contains("--set local.sim_time_s=-1: [local] sim_time_s"), "{refusal}");
}

#[test]
fn degrees_and_swapped_axes_are_noticed() {
    let place = Workplace::new();
    let run = place.run("plan --scene mine --start 10,5,90");
    assert_eq!(run.status, 0, "{run:?}");
    assert!(run.errors.iter().any(|line| line.contains("90 degrees are 1.5708 rad")), "{run:?}");
    let run = place.run("plan --scene mine --start 10,5,1.57");
    assert!(run.errors.is_empty(), "{run:?}");
    let swapped = place.refusal("plan --scene mine --start 5,10");
    assert!(swapped.contains("swapped"), "{swapped}");
    let occupied = place.refusal("plan --scene mine --start 30,31");
    assert!(!occupied.contains("swapped"), "{occupied}");
    // The swapped place must be free for the radius that failed, and another place.
    place.write("strip.txt", room::rows(40, 20, &[]).join("\n"));
    let strip = "plan --map strip.txt --resolution 0.1 --goal 3,1 --radius 0.8 --start";
    let swapped = place.refusal(&format!("{strip} 1,2.5"));
    assert!(swapped.contains("swapped"), "{swapped}");
    // The third is 5 cm too near to the wall, and free with swapped axes.
    for start in ["0.7,1", "0.7,0.7", "0.95,1.15"] {
        let refusal = place.refusal(&format!("{strip} {start}"));
        assert!(refusal.contains("START_") && !refusal.contains("swapped"), "{refusal}");
    }
}

#[test]
fn track_width_in_centimetres_is_noticed() {
    let place = Workplace::new();
    place.write("base.toml", "[base]\ntrack_width_m = 45.0\n");
    let run = place.run("config --base --check base.toml");
    assert_eq!(run.status, 0, "{run:?}");
    assert!(run.errors.iter().any(|line| line.contains("45 cm are 0.45 m")), "{run:?}");
    place.write("base.toml", "[base]\ntrack_width_m = 0.45\n");
    assert!(place.run("config --base --check base.toml").errors.is_empty());
}

#[test]
fn config_without_a_task_names_all_of_them() {
    let error = Workplace::new().refusal("config");
    for name in ["--print", "--schema", "--check", "import-nav2"] {
        assert!(error.contains(name), "{name}: {error}");
    }
}

#[test]
fn error_is_json_too() {
    let place = Workplace::new();
    place.write("empty.log", "");
    place.write("zone.txt", "###\n###\n###\n");
    place.write("hall.txt", "...\n...\n...\n");
    let ends = "--start 1,1 --goal 2,2";
    // What the message begins with, and how it ends.
    let unusable = [
        (format!("plan --map gone.yaml {ends}"), "gone.yaml", "check the path and its permissions"),
        (
            "plan --scene mine --config gone.toml".to_owned(),
            "--config gone.toml",
            "check the path and its permissions",
        ),
        (
            "map empty.log --out a.yaml".to_owned(),
            "empty.log",
            "it is no CARMEN, GMapping or tinySLAM log",
        ),
        (
            format!("drive --map hall.txt {ends} --obstacles gone.json"),
            "gone.json",
            "check the path and its permissions",
        ),
        (
            format!("drive --map hall.txt {ends} --keepout zone.txt"),
            "--start 1,1",
            "choose a place outside the zone, or change the mask",
        ),
        ("replay gone.mcap".to_owned(), "gone.mcap", "name a recording"),
        ("replay .".to_owned(), ".", "name a recording in it"),
        (
            "drive --scene mine --record no/x.mcap".to_owned(),
            "--record no/x.mcap",
            "name a file in a folder that exists",
        ),
        (
            "drive --scene mine --report mine.yaml".to_owned(),
            "--report mine.yaml",
            "choose another name",
        ),
    ];
    let unusable = unusable
        .into_iter()
        .map(|(arguments, at, hint)| (arguments, "unusable_input", json!(at), json!(hint)));
    let usage = ("plan --scene moon".to_owned(), "usage", Value::Null, Value::Null);
    for (arguments, code, place_of_it, hint) in unusable.chain([usage]) {
        let run = place.run(&format!("{arguments} --json"));
        assert_eq!((run.status, run.stdout.lines().count()), (2, 1), "{run:?}");
        let object: Value = serde_json::from_str(&run.stdout).expect("standard output is JSON");
        let error = &object["error"];
        assert_eq!((&error["code"], &error["place"]), (&json!(code), &place_of_it), "{error}");
        if code != "usage" {
            assert_eq!(error["hint"], hint, "{error}");
        }
        let message = error["message"].as_str().expect("a message");
        assert!(run.errors[0].contains(message), "{run:?}");
    }
}

#[test]
fn drive_that_does_not_arrive_says_why() {
    let place = Workplace::new();
    let (status, drive) = place.json("drive --scene crossing --engine cpu --time-limit 2");
    assert_eq!(status, 1);
    let why = drive["why"].as_str().expect("a reason");
    assert!(
        why.starts_with("the time was up: the robot was driving ")
            && why.contains("; driving at ("),
        "{why}"
    );
    let (_, arrived) = place.json("drive --scene dead_end --engine cpu");
    assert_eq!(arrived["why"], Value::Null);
}

#[test]
fn doctor_names_engine_threads_and_features() {
    let place = Workplace::new();
    let (_, object) = place.json("doctor --seconds 0.01");
    assert_fields(&object, "threads whole, checks list, checks[].name text, checks[].ok bool");
    let names: Vec<&str> = object["checks"]
        .as_array()
        .expect("checks")
        .iter()
        .filter_map(|check| check["name"].as_str())
        .collect();
    for name in ["processor", "threads", "GPU", "auto", "features"] {
        assert!(names.contains(&name), "{name} is not in {names:?}");
    }
}

#[cfg(feature = "png")]
#[test]
fn animation_is_a_gif_of_the_drive() {
    let place = Workplace::new();
    let run = place.run("drive --scene dead_end --engine cpu --animation drive.gif --quiet");
    assert_eq!(run.status, 0, "{run:?}");
    let bytes = std::fs::read(place.path("drive.gif")).expect("the animation is written");
    assert!(bytes.starts_with(b"GIF89a"));
    // Width and height, little-endian.
    assert_eq!(bytes[6..10], [0x80, 0x02, 0x90, 0x01]);
    // Each frame has an image descriptor of that size.
    let descriptor = [0x2c, 0, 0, 0, 0, 0x80, 0x02, 0x90, 0x01];
    let frames = bytes.windows(descriptor.len()).filter(|bytes| *bytes == descriptor).count();
    assert!((50..=161).contains(&frames), "{frames} frames");
    let error = place.refusal("drive --scene dead_end --animation drive.png");
    assert!(error.contains(".gif"), "{error}");
}

#[cfg(unix)]
#[test]
fn interrupted_drive_writes_what_it_has() {
    let place = Workplace::new();
    let arguments = "drive --scene mine --engine cpu --threads 1 --report out --record ticks.jsonl";
    let (status, stdout, stderr) = place.interrupted(arguments, "out");
    assert_eq!(status, 1, "{stdout}{stderr}");
    assert!(stdout.contains("the drive was interrupted"), "{stdout}");
    let page = std::fs::read_to_string(place.path("out/index.html")).expect("a page");
    assert!(page.contains("the drive was interrupted"));
    let ticks = std::fs::read_to_string(place.path("ticks.jsonl")).expect("ticks");
    assert!(ticks.lines().count() > 1, "{ticks}");
}

#[cfg(unix)]
#[test]
fn interrupted_density_writes_the_rows_that_it_has() {
    let place = Workplace::new();
    let arguments = "bench density --seconds 0.3 --record rows.csv --report page";
    let (status, _, stderr) = place.interrupted(arguments, "page");
    assert_eq!(status, 1, "{stderr}");
    assert!(stderr.contains("the finished ones are written"), "{stderr}");
    let rows = std::fs::read_to_string(place.path("rows.csv")).expect("rows");
    assert!((2..20).contains(&rows.lines().count()), "{rows}");
    let page = std::fs::read_to_string(place.path("page/index.html")).expect("a page");
    assert!(page.contains("The experiment was interrupted"), "{page}");
}

#[cfg(unix)]
#[test]
fn interrupted_soak_keeps_its_runs_and_goes_on() {
    let place = Workplace::new();
    let arguments = "bench soak --missions 40 --longest 15 --threads 1 --out runs --report page";
    let (status, _, stderr) = place.interrupted(arguments, "runs/cells");
    assert_eq!(status, 1, "{stderr}");
    assert!(stderr.contains("kept in runs: the same command resumes"), "{stderr}");
    let kept = || std::fs::read_dir(place.path("runs/cells")).expect("results").count();
    let before = kept();
    assert!((1..40).contains(&before), "{before} of 40");
    let page = std::fs::read_to_string(place.path("page/index.html")).expect("a page");
    assert!(page.contains("The experiment was interrupted: runs may be missing"), "{page}");
}
