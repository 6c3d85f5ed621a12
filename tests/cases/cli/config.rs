//! `inbye config`: printing, checking, and importing Nav2 files.

use serde_json::Value;

use super::program::{Workplace, assert_fields};

/// A small robot with DWB, a velocity smoother and another node.
pub const NAV2: &str = r#"
controller_server:
  ros__parameters:
    controller_frequency: 10.0
    controller_plugins: ["FollowPath"]
    FollowPath:
      plugin: "dwb_core::DWBLocalPlanner"
      max_vel_x: 0.8
      max_vel_theta: 1.2
      sim_time: 2.0
      PathDist.scale: 24.0
      colour: blue
local_costmap:
  local_costmap:
    ros__parameters:
      robot_radius: 0.25
velocity_smoother:
  ros__parameters:
    max_velocity: [0.6, 0.0, 1.5]
    velocity_timeout: 0.5
planner_server:
  ros__parameters:
    expected_planner_frequency: 1.0
"#;

fn place() -> Workplace {
    let place = Workplace::new();
    place.write("nav2_params.yaml", NAV2);
    place
}

#[test]
fn printed_configuration_is_valid_and_equals_defaults() {
    let place = place();
    for (flags, command) in [
        ("", "plan --map mine.yaml --start 10,5 --goal 80,40 --config"),
        ("--base", "config --base --check"),
    ] {
        let run = place.run(&format!("config --print {flags}"));
        assert_eq!((run.status, run.errors.len()), (0, 0), "{run:?}");
        place.write("all.toml", &run.stdout);
        let used = place.run(&format!("{command} all.toml"));
        assert_eq!((used.status, used.errors.len()), (0, 0), "{used:?}");
        let (status, object) = place.json(&format!("config --print {flags}"));
        assert_eq!(status, 0);
        assert_fields(&object, "config text, keys list, keys[].key text, keys[].description text");
        let text = object["config"].as_str().expect("a text");
        assert_eq!(text.trim_end(), run.stdout.trim_end());
    }
    let drive = "drive --map mine.yaml --start 10,5 --goal 14,5 --json";
    place.write("all.toml", place.run("config --print").stdout);
    let digest = |arguments: &str| {
        let object: Value = serde_json::from_str(&place.run(arguments).stdout).expect("JSON");
        object["trace_digest"].clone()
    };
    assert_eq!(digest(&format!("{drive} --config all.toml")), digest(drive));
}

#[test]
fn check_reports_errors_of_the_commands() {
    let place = place();
    place.write("good.toml", "[local]\nvx_samples = 8\n");
    place.write("bad.toml", "[local]\nvx_sample = 8\n");
    place.write("base.toml", "[supervisor]\nrate_hz = 1.0\n");
    let run = place.run("config --check good.toml");
    assert_eq!((run.status, &*run.stdout), (0, "good.toml: ok\n"), "{run:?}");
    let (_, object) = place.json("config --check good.toml");
    assert_fields(&object, "file text, ok bool");
    for (period_s, is_kept) in [(0.009, false), (0.01, true), (0.25, true), (0.26, false)] {
        place.write("period.toml", format!("[local]\ncontrol_period_s = {period_s}\n"));
        let run = place.run("config --check period.toml");
        let text = "`inbye node` keeps 0.01 to 0.25 s";
        let warns = run.errors.iter().any(|line| line.contains(text));
        assert_eq!((run.status, warns), (0, !is_kept), "{period_s}: {run:?}");
    }
    for (arguments, words) in [
        ("--check bad.toml", "bad.toml: line 2; did you mean `vx_samples`?"),
        ("--check gone.toml", "--check gone.toml: cannot be read"),
        ("--check base.toml", "base.toml: line 1; unknown field `supervisor`; a base; with --base"),
        (
            "--base --check base.toml",
            "base.toml: line 2, `rate_hz = 1.0`: [supervisor] rate_hz is 1; 10 to 1000",
        ),
        ("--base --check good.toml", "good.toml: line 1; unknown field `local`; without --base"),
        ("", "--print; --check; --help"),
        ("--print --check good.toml", "--print; --check"),
        ("--print import-nav2 nav2_params.yaml", "import-nav2; --print"),
    ] {
        let refusal = place.refusal(&format!("config {arguments}"));
        for word in words.split("; ") {
            assert!(refusal.contains(word), "{arguments}: no {word:?} in: {refusal}");
        }
    }
}

#[test]
fn imported_nav2_settings_drive() {
    let place = place();
    let import = "config import-nav2 nav2_params.yaml";
    let run = place.run(import);
    assert_eq!(run.status, 0, "{run:?}");
    for line in [
        "# From velocity_smoother.max_velocity (along x).",
        "max_vel_x = 0.6",
        "max_vel_theta = 1.2",
        "sim_time_s = 2.0",
        "control_period_s = 0.1",
    ] {
        assert!(run.stdout.lines().any(|found| found == line), "{line}: {run:?}");
    }
    for words in [
        "different meaning:",
        "  controller_server.FollowPath.PathDist.scale: ",
        "unknown:",
        "  controller_server.FollowPath.colour: ",
        "target_timeout_s = 0.5",
        "ignored nodes: planner_server",
        "7 parameters mapped, 4 without an equivalent",
    ] {
        assert!(run.errors.iter().any(|line| line.contains(words)), "{words}: {run:?}");
    }
    let written = place.run(&format!("{import} --output robot.toml --base-output base.toml"));
    assert_eq!((written.status, &*written.stdout), (0, ""), "{written:?}");
    let text = std::fs::read_to_string(place.path("robot.toml")).expect("it was written");
    assert_eq!(text.trim_end(), run.stdout.trim_end());
    let check = place.run("config --base --check base.toml");
    assert_eq!(check.status, 0, "{check:?}");
    let drive = "drive --map mine.yaml --start 10,5 --goal 14,5 --config robot.toml";
    let (status, object) = place.json(drive);
    assert_eq!((status, &object["reached"]), (0, &Value::Bool(true)));

    let (status, object) = place.json(import);
    assert_eq!(status, 0);
    assert_fields(
        &object,
        "config text, base_config text, mapped list, mapped[].parameter text, mapped[].settings list, unmapped list, \
        unmapped[].parameter text, unmapped[].reason text, unmapped[].explanation text, ignored_nodes list, warnings list",
    );
}

#[test]
fn warnings_of_an_import_are_on_standard_error_too() {
    let place = place();
    place.write(
        "no_shape.yaml",
        "controller_server:\n  ros__parameters: {controller_frequency: 10.0}\n",
    );
    let warning = "warning: no costmap has a footprint or a robot_radius";
    for arguments in
        ["no_shape.yaml --output robot.toml", "no_shape.yaml --quiet", "no_shape.yaml --json"]
    {
        let run = place.run(&format!("config import-nav2 {arguments}"));
        let found = run.errors.iter().filter(|line| line.starts_with(warning)).count();
        assert_eq!((run.status, found), (0, 1), "{arguments}: {run:?}");
    }
    let text = std::fs::read_to_string(place.path("robot.toml")).expect("it was written");
    assert!(text.contains("# Warning: no costmap has a footprint"), "{text}");
}

#[test]
fn unusable_nav2_files_are_rejected() {
    let place = place();
    let robots =
        |name: &str| NAV2.replace("controller_server:", &format!("{name}/controller_server:"));
    for (name, text) in [
        ("empty.yaml", String::new()),
        ("cut.yaml", NAV2.replace("0.8", "[0.8")),
        ("map.yaml", "image: mine.png\nresolution: 0.1\n".to_owned()),
        ("text.yaml", NAV2.replace("sim_time: 2.0", "sim_time: $(var time)")),
        ("zero.yaml", NAV2.replace("max_vel_theta: 1.2", "max_vel_theta: 0.0")),
        ("far.yaml", NAV2.replace("sim_time: 2.0", "sim_time: 4000.0")),
        (
            "robots.yaml",
            robots("/one")
                + &robots("/two")
                    .replace("velocity_smoother:", "/two/velocity_smoother:")
                    .replace("planner_server:", "/two/planner_server:")
                    .replace("local_costmap:\n  local", "/two/local_costmap:\n  local"),
        ),
    ] {
        place.write(name, text);
    }
    place.write("keep.toml", "# kept\n");
    for (arguments, words) in [
        ("gone.yaml", "gone.yaml; cannot be read; check the path"),
        ("mine.png", "mine.png; not UTF-8 text"),
        ("empty.yaml", "empty.yaml; controller_server"),
        ("cut.yaml", "cut.yaml: line"),
        ("map.yaml", "map.yaml; ros__parameters"),
        (
            "text.yaml --output keep.toml",
            "controller_server.FollowPath.sim_time is \"$(var time)\"; a finite number",
        ),
        (
            "zero.yaml --output keep.toml",
            "controller_server.FollowPath.max_vel_theta; max_vel_theta is 0; above zero",
        ),
        ("far.yaml", "controller_server.FollowPath.sim_time; sim_time_s is 4000; at most 1000"),
        ("robots.yaml", "the root, `one`, `two`; --namespace"),
        ("robots.yaml --namespace three", "`three`; `one`, `two`"),
        ("nav2_params.yaml --output out.yaml", "--output out.yaml; .toml"),
        ("nav2_params.yaml --output gone/out.toml", "--output gone/out.toml; folder that exists"),
        ("nav2_params.yaml --output o.toml --base-output o.toml", "--output writes this file"),
    ] {
        let refusal = place.refusal(&format!("config import-nav2 {arguments}"));
        for word in words.split("; ") {
            assert!(refusal.contains(word), "{arguments}: no {word:?} in: {refusal}");
        }
    }
    let kept = std::fs::read_to_string(place.path("keep.toml")).expect("it is there");
    assert_eq!(kept, "# kept\n", "an error leaves files unchanged");
}

/// An unknown key of a map file may belong to another tool; only a likely misspelling is noted.
#[test]
fn misspelled_map_key_is_noted() {
    let place = place();
    let yaml = std::fs::read_to_string(place.path("mine.yaml")).expect("the map is there");
    place.write("odd.yaml", yaml + "mdoe: scale\nauthor: me\n");
    place.write(
        "problem.json",
        r#"{"map": {"file": "odd.yaml"}, "robot": {"pose": [10, 5, 0]}, "target": [12, 5]}"#,
    );
    for arguments in [
        "plan --map odd.yaml --start 10,5 --goal 40,5",
        "evaluate --problem problem.json --engine cpu --json",
    ] {
        let run = place.run(arguments);
        assert_eq!((run.status, run.errors.len()), (0, 1), "{run:?}");
        for word in ["odd.yaml: line 7", "`mdoe`", "did you mean `mode`?"] {
            assert!(run.errors[0].contains(word), "{run:?}");
        }
    }
}
