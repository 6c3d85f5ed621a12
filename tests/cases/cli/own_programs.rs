//! Programs that decide, plan and simulate in place of inbye.

use std::fs;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::program::{Run, Workplace};

pub(super) const DRIVE: &str =
    "drive --map room.txt --resolution 0.2 --start 1,1.5 --goal 5,1.5 --engine cpu";

/// A shell script that answers the first message, and each further one by these lines.
pub(super) fn script(place: &Workplace, name: &str, each: &str) {
    let lines = [
        "read -r first",
        r#"echo '{"protocol": 1, "name": "a script", "wants": []}'"#,
        &format!("while read -r message; do {each}; done"),
    ];
    place.write(name, lines.join("\n") + "\n");
}

/// Runs the drive with more arguments; `'` encloses those with spaces.
pub(super) fn driven(place: &Workplace, more: &str) -> (i32, Value) {
    let quoted = |(index, part): (usize, &str)| -> Vec<String> {
        let words = part.split_whitespace().map(str::to_owned);
        if index % 2 == 1 { vec![part.to_owned()] } else { words.collect() }
    };
    let words = DRIVE.split(' ').map(str::to_owned).chain(["--json".to_owned()]);
    let words: Vec<String> = words.chain(more.split('\'').enumerate().flat_map(quoted)).collect();
    object(&place.run_words(&words.iter().map(String::as_str).collect::<Vec<_>>()))
}

pub(super) fn object(run: &Run) -> (i32, Value) {
    let object = serde_json::from_str(&run.stdout);
    (run.status, object.unwrap_or_else(|error| panic!("{error}: {run:?}")))
}

pub(super) fn text<'v>(object: &'v Value, name: &str) -> &'v str {
    object[name].as_str().unwrap_or_else(|| panic!("{name} of {object}"))
}

#[test]
fn controller_drives_to_the_goal_and_equal_answers_give_equal_traces() {
    let place = Workplace::with_room();
    script(&place, "straight.sh", r#"echo '{"linear": 0.5, "angular": 0}'"#);
    let (status, object) = driven(&place, "--controller 'sh straight.sh'");
    assert_eq!((status, &object["reached"]), (0, &json!(true)), "{object}");
    assert_eq!(text(&object, "engine"), "controller a script");
    // Four metres at half a metre per second, less the goal's tolerance.
    let time_s = object["time_s"].as_f64().expect("a time");
    assert!((7.5..12.0).contains(&time_s), "{object}");
    let (_, again) = driven(&place, "--controller 'sh straight.sh'");
    assert_eq!(text(&object, "trace_digest"), text(&again, "trace_digest"));
    script(&place, "other.sh", r#"echo '{"linear": 0.49, "angular": 0}'"#);
    let (_, other) = driven(&place, "--controller 'sh other.sh'");
    assert_ne!(text(&object, "trace_digest"), text(&other, "trace_digest"));
}

#[test]
fn commands_beyond_the_limits_are_clamped() {
    let place = Workplace::with_room();
    script(&place, "fast.sh", r#"echo '{"linear": 1000, "angular": 0}'"#);
    let set = "--set robot.limits.max_vel_x=0.4";
    let (_, object) = driven(&place, &format!("{set} --controller 'sh fast.sh'"));
    let [travelled_m, time_s] =
        ["travelled_m", "time_s"].map(|name| object[name].as_f64().expect("a number"));
    assert!(travelled_m > 3.0 && travelled_m / time_s < 0.41, "{object}");
}

/// Its controller forgets the yaw of the goal: the distance of zero would explain nothing.
#[test]
fn failure_of_a_robot_at_its_goal_names_the_angle_to_the_yaw() {
    let place = Workplace::with_room();
    script(&place, "stands.sh", r#"echo '{"linear": 0, "angular": 0}'"#);
    let drive = DRIVE.replace("--goal 5,1.5", "--goal 1.05,1.5,2");
    let words = drive.split(' ').chain(["--json", "--controller", "sh stands.sh"]);
    let (status, object) = object(&place.run_words(&words.collect::<Vec<_>>()));
    let why = text(&object, "why");
    let turn = why.contains("the robot is at the goal, and must turn by 2.00 rad to its yaw");
    assert!(status == 1 && turn, "{why}");
}

/// Each of these programs ends the mission with a reason; none ends inbye.
#[test]
fn failing_controller_is_a_result_with_its_reason() {
    let place = Workplace::with_room();
    let cases = [
        (
            "echo why >&2; exit 3",
            "INVALID_CONTROLLER: a script: the program ended (exit status 3): why",
        ),
        ("kill -SEGV $$", "the program ended (killed by SIGSEGV)"),
        // What it started holds its output open.
        ("sleep 100 & exit 3", "the program ended (exit status 3)"),
        (
            r#"printf '{"linear": 0, "angular": 0}\n{"linear": 9, "angular": 0}\n'"#,
            // Either of the two lines, by when the program writes the second one.
            "wrote a second line for one message: `{\"linear\": ",
        ),
        ("head -c 1100000 /dev/zero; echo", "wrote a line that is longer than 1 MiB"),
        (r"printf '\033[31mred\n'", r"`\u{1b}[31mred` is no answer"),
        ("echo nonsense", "INVALID_CONTROLLER: a script: `nonsense` is no answer"),
        (r#"echo '{"linear": 0.5}'"#, "write either `linear` and `angular`, or `error`"),
        (
            r#"echo '{"linear": 1e999, "angular": 0}'"#,
            "`{\"linear\": 1e999, \"angular\": 0}` is no answer: number out of range (column 16)",
        ),
        (
            r#"echo '{"linear": NaN, "angular": 0}'"#,
            "NaN in column 12 is not JSON: each number must be finite",
        ),
        ("sleep 100", "CONTROLLER_TIMED_OUT: a script: no answer for 0.5 s"),
    ];
    for (each, expected) in cases {
        script(&place, "failing.sh", each);
        let more = "--controller 'sh failing.sh' --set controller.timeout_s=0.5";
        let (status, object) = driven(&place, more);
        assert_eq!(status, 1, "{each}: {object}");
        assert!(text(&object, "fault").contains(expected), "{each}: {object}");
        assert_eq!(object["collided"], json!(false));
    }
}

/// The person does not yield, and walks into the robot from the side.
#[test]
fn person_who_walks_into_the_standing_robot_is_named_in_the_headline() {
    let place = Workplace::with_room();
    script(&place, "stands.sh", r#"echo '{"linear": 0, "angular": 0}'"#);
    place.write("person.json", r#"[{"radius": 0.3, "keyframes": [[0, 1, 2.6], [2, 1, 1.5]]}]"#);
    let more = "--controller 'sh stands.sh' --obstacles person.json";
    let (status, object) = driven(&place, more);
    assert_eq!((status, &object["collided"]), (1, &json!(true)), "{object}");
    let words = DRIVE.split(' ').chain(["--controller", "sh stands.sh"]);
    let words: Vec<&str> = words.chain(["--obstacles", "person.json"]).collect();
    let text = place.run_words(&words).stdout;
    let headline = "a moving obstacle ran into the standing robot: 0.0 m in ";
    assert!(text.starts_with(headline) && text.contains("touched moving obstacle 0"), "{text}");
}

#[test]
fn controller_without_a_valid_velocity_stands_until_the_navigator_gives_up() {
    let place = Workplace::with_room();
    script(&place, "refuses.sh", r#"echo '{"error": "no way"}'"#);
    let more = "--controller 'sh refuses.sh' --set navigator.movement_time_allowance=2";
    let (status, object) = driven(&place, more);
    assert_eq!((status, object["travelled_m"].as_f64()), (1, Some(0.0)), "{object}");
    let fault = text(&object, "fault");
    assert!(fault.starts_with("NO_VALID_CONTROL"), "{fault}");
    assert!(fault.ends_with("m from the goal: a script: no way"), "{fault}");
}

#[test]
fn program_that_cannot_be_used_is_unusable_input() {
    let place = Workplace::with_room();
    place.write("old.sh", "read -r first\necho '{\"protocol\": 0}'\n");
    for (option, expected) in [
        ("--controller ./missing", "(os error 2), in the working folder /"),
        ("--controller no-such-program", "(os error 2), in the folders of PATH"),
        ("--controller ./libmine.so", "`inbye-controller-host ./libmine.so`"),
        ("--controller 'sh missing.sh'", "(in the working folder /"),
        ("--controller 'sh old.sh'", "speaks protocol 0, this inbye speaks 1"),
        ("--global-planner 'sh missing.sh'", "INVALID_PLANNER"),
        ("--simulator 'sh missing.sh'", "the simulator `sh missing.sh`: the program ended"),
        (
            "--simulator 'sh missing.sh' --set simulation.lidar.mount_x_m=0.2",
            "it has its own lidar: leave mount_x_m, mount_y_m, mount_yaw_rad, scan_rate_hz and blind_time_s",
        ),
        ("--controller ''", "it must be a program and its arguments"),
    ] {
        let (status, object) = driven(&place, option);
        assert_eq!(status, 2, "{option}: {object}");
        let message = text(&object["error"], "message");
        assert!(message.contains(expected), "{option}: {message}");
        assert!(!message.contains('\n'), "{option}: {message}");
    }
}

/// With a deadline inbye does not wait: a late answer is dropped, and the robot stands.
#[test]
fn late_answers_do_not_delay_the_drive() {
    let place = Workplace::with_room();
    script(&place, "slow.sh", r#"sleep 1; echo '{"linear": 0.5, "angular": 0}'"#);
    let began = Instant::now();
    let (_, object) = driven(&place, "--controller 'sh slow.sh' --deadline 20 --time-limit 3");
    // 31 ticks that wait for each answer take half a minute.
    assert!(began.elapsed() < Duration::from_secs(20), "{:?}", began.elapsed());
    let misses = object["deadline"]["misses"].as_u64().expect("a count");
    assert!(misses > 20 && object["travelled_m"].as_f64() < Some(0.3), "{object}");
    let more = "--deadline 20 --set navigator.movement_time_allowance=2";
    let (_, object) = driven(&place, &format!("{more} --controller 'sh slow.sh'"));
    assert!(text(&object, "fault").ends_with("answers were late"), "{object}");
}

/// The terminal sends Ctrl-C to all processes of its foreground group.
#[cfg(unix)]
#[test]
fn ctrl_c_reaches_no_program_and_stores_no_failure() {
    let place = Workplace::with_room();
    script(&place, "stands.sh", r#"sleep 0.02; echo '{"linear": 0, "angular": 0}'"#);
    place.write("own.toml", "controller.command = [\"sh\", \"stands.sh\"]\n");
    let drive = format!("{DRIVE} --config own.toml --report out");
    let (status, stdout, stderr) = place.interrupted(&drive, "out");
    assert_eq!(status, 1, "{stdout}{stderr}");
    assert!(stdout.contains("the drive was interrupted"), "{stdout}");
    assert!(!stdout.contains("INVALID_CONTROLLER"), "{stdout}");
    // One that does not answer any more: the wait ends, long before its time is up.
    script(&place, "stands.sh", "sleep 100");
    let began = Instant::now();
    let (status, stdout, stderr) =
        place.interrupted(&format!("{DRIVE} --config own.toml --report deaf"), "deaf");
    assert!(status == 1 && began.elapsed() < Duration::from_secs(8), "{stdout}{stderr}");
    assert!(stdout.contains("the drive was interrupted"), "{stdout}");
    // A program that ends after Ctrl-C for a reason of its own.
    script(&place, "stands.sh", "sleep 3; exit 1");
    let soak = "bench soak --missions 1 --longest 15 --threads 1 --config own.toml --out runs";
    let (status, _, stderr) = place.interrupted(soak, "runs/cells");
    assert_eq!(status, 1, "{stderr}");
    let kept = fs::read_dir(place.path("runs/cells")).expect("results").count();
    assert_eq!(kept, 0, "{stderr}");
}

#[test]
fn recording_of_a_controller_replays_without_its_program() {
    let place = Workplace::with_room();
    script(&place, "straight.sh", r#"echo '{"linear": 0.5, "angular": 0.01}'"#);
    driven(&place, "--controller 'sh straight.sh' --record drive.mcap");
    place.write("straight.sh", "exit 1\n");
    let (status, object) = place.json("replay drive.mcap --engine cpu");
    assert_eq!((status, &object["agree"]), (0, &json!(true)), "{object}");
}

/// `plan` asks the program too, that of the option or that of the configuration.
#[test]
fn plan_has_the_path_of_the_program() {
    let place = Workplace::with_room();
    script(&place, "plans.sh", r#"echo '{"path": [[1, 1.5], [3, 2.5], [5, 1.5]]}'"#);
    place.write("own.toml", "global_planner.command = [\"sh\", \"plans.sh\"]\n");
    let plan = "plan --map room.txt --resolution 0.2 --start 1,1.5 --goal 5,1.5";
    let planned = |more: &[&str]| {
        let words: Vec<&str> = plan.split(' ').chain(more.iter().copied()).collect();
        place.run_words(&words)
    };
    for more in [["--global-planner", "sh plans.sh"], ["--config", "own.toml"]] {
        let (status, object) = object(&planned(&[more[0], more[1], "--json"]));
        assert_eq!((status, &object["global_planner"]), (0, &json!("sh plans.sh")), "{object}");
        assert_eq!(object["path"], json!([[1.0, 1.5], [3.0, 2.5], [5.0, 1.5]]), "{object}");
        assert_eq!(object["exact"], json!(false), "{object}");
    }
    let run = planned(&["--global-planner", "sh plans.sh"]);
    assert!(run.stdout.contains("planned by sh plans.sh in "), "{run:?}");
    script(&place, "plans.sh", r#"echo '{"error": "no way"}'"#);
    let run = planned(&["--global-planner", "sh plans.sh", "--radius", "0.1"]);
    assert_eq!(run.status, 1, "{run:?}");
    assert!(run.stdout.contains("(5.00, 1.50) by a script: no way"), "{run:?}");
    let run = planned(&["--global-planner", "sh missing.sh"]);
    let names_it = |line: &String| line.contains("sh missing.sh: the program ended");
    assert!(run.status == 2 && run.errors.iter().any(names_it), "{run:?}");
}

/// The state of a simulated robot at the start.
pub(super) const STATE: &str = r#"{"odometry": {"pose": [1, 1.5, 0], "twist": [0, 0]}, "scan": {"angle_min": -3, "angle_increment": 0.1, "range_max": 9, "ranges": [1, null, 9]}, "truth": {"pose": [1, 1.5, 0], "twist": [0, 0], "contact": false}}"#;

/// A simulator whose robot stands: it answers every step with the pose of the start.
#[test]
fn simulator_that_fails_ends_the_drive_with_its_reason() {
    let place = Workplace::with_room();
    let state = STATE;
    place.write("state.json", format!("{state}\n"));
    script(&place, "stands.sh", "cat state.json; read -r message; cat state.json; exit 0");
    let (status, object) = driven(&place, "--simulator 'sh stands.sh'");
    assert_eq!(status, 1, "{object}");
    let why = text(&object, "why");
    assert!(why.contains("the simulator failed: the program ended (exit status 0)"), "{why}");
    // An absurd pose is the simulator's failure, not that of the settings.
    place.write("far.json", state.replace("[1, 1.5, 0]", "[1e300, 0, 0]") + "\n");
    script(&place, "stands.sh", "cat state.json; read -r message; cat far.json");
    let (status, object) = driven(&place, "--simulator 'sh stands.sh'");
    let why = text(&object, "why");
    assert!(
        status == 1 && why.contains("the simulator failed: `odometry.pose` is 1e300 m"),
        "{why}"
    );
    // Odometry that begins at zero would put the robot into a wall of its map.
    let from_zero = state.replacen("[1, 1.5, 0]", "[0, 0, 0]", 1);
    place.write("state.json", from_zero + "\n");
    script(&place, "stands.sh", "cat state.json");
    let (status, object) = driven(&place, "--simulator 'sh stands.sh'");
    let message = text(&object["error"], "message");
    let expected = "`odometry.pose` is [0.000, 0.000, 0.000] at step 0, and `truth.pose` [1.000, 1.500, 0.000]";
    assert!(status == 2 && message.contains(expected), "{object}");
    place.write("state.json", state.replace(r#""range_max": 9"#, r#""range_max": -9"#) + "\n");
    script(&place, "stands.sh", "cat state.json");
    let (status, object) = driven(&place, "--simulator 'sh stands.sh'");
    assert_eq!(status, 2, "{object}");
    let message = text(&object["error"], "message");
    assert!(message.contains("range_max of the scan is not finite and above zero"), "{message}");
}

/// A program that cannot be used is no planner that drives badly.
#[test]
fn experiment_with_a_program_that_cannot_be_used_stores_nothing() {
    let place = Workplace::with_room();
    script(&place, "straight.sh", r#"echo '{"linear": 0.3, "angular": 0}'"#);
    let plan = |script: &str| {
        format!(
            "seeds = [0]\n[configs.inbye]\n[configs.mine]\ncontroller.command = [\"sh\", \"{script}\"]\n\
             [[worlds]]\nkind = \"map\"\npath = \"room.txt\"\nresolution_m = 0.2\n\
             routes = [{{ start = [1, 1.5, 0], goal = [5, 1.5] }}]\n"
        )
    };
    place.write("plan.toml", plan("missing.sh"));
    for command in ["bench compare", "sweep"] {
        let error = place.refusal(&format!("{command} plan.toml --out cells"));
        assert!(error.contains("configs.mine: INVALID_CONTROLLER: sh missing.sh: "), "{error}");
        let kept = fs::read_dir(place.path("cells/cells")).expect("a folder of results").count();
        assert_eq!(kept, 0, "{error}");
    }
    place.refusal("bench compare plan.toml");
    place.write("plan.toml", plan("straight.sh"));
    let (status, object) = place.json("bench compare plan.toml --out other");
    assert_eq!((status, &object["ranked"][1]["reached_share"]), (0, &json!(1.0)), "{object}");
    // Where every run has its result, no program is needed.
    place.json("bench compare plan.toml --out other");
}

/// A plan with a configuration `mine`, and the path to its only world.
fn room_plan(mine: &str) -> String {
    format!(
        "seeds = [0]\n[configs.mine]\n{mine}\n[[worlds]]\nkind = \"map\"\npath = \"room.txt\"\nresolution_m = 0.2\n\
         routes = [{{ start = [1, 1.5, 0], goal = [5, 1.5] }}]\n"
    )
}

/// The load of the machine is not part of a cell's key.
#[test]
fn runs_whose_program_did_not_answer_are_driven_again() {
    let place = Workplace::with_room();
    script(&place, "slow.sh", r#"[ -e ready ] || sleep 9; echo '{"linear": 0.3, "angular": 0}'"#);
    let plan = "controller.command = [\"sh\", \"slow.sh\"]\ncontroller.timeout_s = 0.3";
    place.write("plan.toml", room_plan(plan));
    let compare = "bench compare plan.toml --out cells --json";
    let (_, failed) = object(&place.run(compare));
    let faults = text(&failed["ranked"][0], "faults");
    assert!(faults.contains("CONTROLLER_TIMED_OUT: 1"), "{failed}");
    // A result stays until a better one replaces it: another process may have driven the cell meanwhile.
    let cells = || fs::read_dir(place.path("cells/cells")).expect("a folder").count();
    fs::rename(place.path("slow.sh"), place.path("gone.sh")).expect("renamed");
    assert_eq!((place.run(compare).status, cells()), (2, 1));
    fs::rename(place.path("gone.sh"), place.path("slow.sh")).expect("renamed");
    place.write("ready", "");
    let run = place.run(compare);
    let (status, ranked) = object(&run);
    assert_eq!((status, &ranked["ranked"][0]["reached_share"]), (0, &json!(1.0)), "{run:?}");
    let note = "1 earlier runs in which a program did not start or did not answer";
    assert!(run.errors.iter().any(|line| line.contains(note)), "{run:?}");
}

#[test]
fn settings_that_no_decision_can_use_do_not_start_and_errors_of_a_plan_name_their_line() {
    let place = Workplace::with_room();
    place.write("plan.toml", room_plan("local.max_clearance_m = 11"));
    let (_, object) = object(&place.run("bench compare plan.toml --json"));
    let faults = text(&object["ranked"][0], "faults");
    assert!(
        faults.starts_with("did not start: 1, NO_DECISION: the sum of max_clearance_m"),
        "{faults}"
    );
    for (mine, expected) in [
        (
            "local = { vx_samples = 0 }",
            "line 3, `local = { vx_samples = 0 }`: configs.mine: [local] vx_samples is 0",
        ),
        ("local = { vx = 1 }", "line 3, `local = { vx = 1 }`: configs.mine: unknown field `vx`"),
        (
            "local = { vx_samples = \"a\" }",
            "configs.mine: invalid type: string \"a\", expected a whole number",
        ),
    ] {
        place.write("plan.toml", room_plan(mine));
        let error = place.refusal("bench compare plan.toml");
        assert!(error.contains(expected), "{error}");
    }
    place.write("plan.toml", room_plan("").replace("configs.mine", r#"configs."a\nb""#));
    let error = place.refusal("bench compare plan.toml");
    assert!(error.contains(r"configs is a\nb: it must be a name without control"), "{error}");
}

#[test]
fn comparison_ranks_planners_and_writes_a_page() {
    let place = Workplace::with_room();
    script(&place, "straight.sh", r#"echo '{"linear": 0.3, "angular": 0}'"#);
    script(&place, "stands.sh", r#"echo '{"linear": 0, "angular": 0}'"#);
    place.write(
        "plan.toml",
        "seeds = [0, 1]\n[configs.inbye]\n[configs.straight]\ncontroller.command = [\"sh\", \"straight.sh\"]\n\
         [configs.stands]\ncontroller.command = [\"sh\", \"stands.sh\"]\nnavigator.movement_time_allowance = 2\n\
         [[worlds]]\nkind = \"map\"\npath = \"room.txt\"\nresolution_m = 0.2\n\
         routes = [{ start = [1, 1.5, 0], goal = [5, 1.5] }]\n",
    );
    let run = "bench compare plan.toml --out cells --report page --play 1 --threads 2 --json";
    let (status, object) = object(&place.run(run));
    assert_eq!(status, 0, "{object}");
    let ranked = object["ranked"].as_array().expect("a list");
    let names: Vec<&str> = ranked.iter().map(|planner| text(planner, "planner")).collect();
    assert_eq!(names, ["inbye", "straight", "stands"]);
    assert_eq!(ranked[1]["reached_share"], json!(1.0));
    // One world shows nothing about others.
    assert_eq!(text(&ranked[2], "verdict"), "too_few_worlds");
    assert_eq!(text(&ranked[2], "faults"), "FAILED_TO_MAKE_PROGRESS: 2");
    assert_eq!(ranked[2]["failed_share"], json!(1.0));
    let page = fs::read_to_string(place.path("page/index.html")).expect("the page");
    assert!(page.contains("1. inbye") && page.contains("run-map-"), "{page}");
    // A changed program is another cell; the others keep their results.
    let keys = |object: &Value| -> Vec<String> {
        let rows = object["rows"].as_array().expect("a list");
        rows.iter().map(|row| format!("{} {}", row["config"], row["key"])).collect()
    };
    script(&place, "stands.sh", r#"echo '{"linear": 0, "angular": 0.1}'"#);
    let (_, changed) = place.json("bench compare plan.toml --out changed --threads 2");
    let (before, after) = (keys(&object), keys(&changed));
    let differ: Vec<_> = before.iter().zip(&after).filter(|(one, other)| one != other).collect();
    assert!(differ.len() == 2 && differ.iter().all(|it| it.0.contains("stands")), "{differ:?}");
}

/// Planners whose names differ only in letters that a file's name cannot have, one that never drives, and two sets of weights.
#[test]
fn comparison_plays_each_run_under_its_own_name() {
    let place = Workplace::with_room();
    script(&place, "dies.sh", "exit 1");
    let worlds = "[[worlds]]\nkind = \"map\"\npath = \"room.txt\"\nresolution_m = 0.2\n\
         routes = [{ start = [1, 1.5, 0], goal = [5, 1.5] }]\n";
    place.write(
        "plan.toml",
        format!(
            "[configs.\"VFH+\"]\n[configs.\"VFH-\"]\nrobot.limits.max_vel_x = 0.5\n\
             [configs.dies]\ncontroller.command = [\"sh\", \"dies.sh\"]\n{worlds}"
        ),
    );
    let run = place.run("bench compare plan.toml --report page --play 1 --threads 2");
    assert_eq!(run.status, 0, "{run:?}");
    assert!(run.stdout.contains("dies: faults: "), "{run:?}");
    let page = fs::read_to_string(place.path("page/index.html")).expect("the page");
    assert!(page.contains("faults: "), "{page}");
    let links: Vec<&str> = page.split("<a href=\"").skip(1).collect();
    let links = links.iter().filter_map(|link| link.split('"').next());
    let links: Vec<&str> = links.filter(|link| link.starts_with("run-")).collect();
    let read = |link: &&str| fs::read_to_string(place.path(&format!("page/{link}"))).expect(link);
    let pages: Vec<String> = links.iter().map(read).collect();
    for name in ["VFH+", "VFH-"] {
        let titled = pages.iter().filter(|page| page.contains(&format!("seed 0, {name}<")));
        assert_eq!(titled.count(), 1, "{name}: {links:?}");
    }
    place.write("weights.toml", format!("[weights.fast]\nvelocity = 0.6\n[weights.shy]\n{worlds}"));
    let (_, object) = place.json("bench compare weights.toml --threads 2");
    let ranked = object["ranked"].as_array().expect("a list");
    let mut names: Vec<&str> = ranked.iter().map(|planner| text(planner, "planner")).collect();
    names.sort_unstable();
    assert_eq!(names, ["fast", "shy"]);
    assert!(ranked.iter().all(|planner| planner["runs"] == 1), "{object}");
}
