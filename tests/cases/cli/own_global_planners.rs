//! Programs that plan global paths in place of inbye.

use std::fs;

use serde_json::json;

use super::own_programs::{DRIVE, driven, object, script, text};
use super::program::Workplace;

/// The answer with the straight path.
const PATH: &str = r#"echo '{"path": [[1, 1.5], [5, 1.5]]}'"#;

/// A room with a person who stands on the straight path, so that a program is asked again.
fn with_person() -> Workplace {
    let place = Workplace::with_room();
    place.write("person.json", r#"[{"radius": 0.3, "keyframes": [[0, 3, 1.5], [1, 3, 1.5]]}]"#);
    place
}

#[test]
fn global_planner_gives_the_path_and_wrong_paths_are_rejected() {
    let place = Workplace::with_room();
    let path = |points: &str| format!(r#"echo '{{"path": [{points}]}}'"#);
    let first = path("[1, 1.5], [3, 2.5], [5, 1.5]");
    let none = r#"echo '{"error": "no other path"}'"#;
    let each = format!("if [ $asked ]; then {none}; else asked=1; {first}; fi");
    script(&place, "plans.sh", &each);
    let words = DRIVE.split(' ').chain(["--verbose", "--global-planner", "sh plans.sh"]);
    let run = place.run_words(&words.collect::<Vec<_>>());
    // The path through (3, 2.5) has 4.47 m, the straight one 4 m.
    let has_plan = |line: &String| line.contains("a plan of 4.5 m, 0 cells expanded");
    assert!(run.status == 0 && run.errors.iter().any(has_plan), "{run:?}");
    for (points, expected) in [
        ("[1, 1.5], [3, 9.0], [5, 1.5]", "point 1 of the path is not on the map"),
        ("[1, 1.5], [3, 0.1], [5, 1.5]", "the path crosses an obstacle"),
        ("[1, 1.5], [1e200, 0], [5, 1.5]", "point 1 of the path is not on the map"),
        ("[1, 1.5], [3, 1.5, 0], [5, 1.5]", "point 1 of `path` has 3 numbers: write [x, y]"),
        ("[1, 1.5], [4, 1.5]", "the path ends 1.00 m from the goal"),
        ("[1, 1.5]", "at least two points"),
    ] {
        script(&place, "plans.sh", &path(points));
        let (status, object) = driven(&place, "--global-planner 'sh plans.sh'");
        let message = text(&object["error"], "message");
        assert!(status == 2 && message.contains(expected), "{points}: {message}");
    }
}

#[test]
fn global_planner_that_fails_during_the_drive_ends_it() {
    let place = with_person();
    for (then, expected) in [
        ("echo expired >&2; exit 1", "the program ended (exit status 1): expired"),
        ("echo nonsense", "`nonsense` is no answer"),
        (r#"echo '{"path": [[1, 1.5], [9, 1.5]]}'"#, "the path ends 4.00 m from the goal"),
        ("sleep 100", "no answer for 0.5 s"),
    ] {
        script(&place, "fails.sh", &format!("if [ $asked ]; then {then}; fi; asked=1; {PATH}"));
        let more = "--global-planner 'sh fails.sh' --obstacles person.json";
        let (status, object) =
            driven(&place, &format!("{more} --set global_planner.timeout_s=0.5"));
        let fault = text(&object, "fault");
        assert!(status == 1 && fault.starts_with("INVALID_PLANNER: a script: "), "{then}: {fault}");
        assert!(fault.contains(expected), "{then}: {fault}");
    }
}

#[test]
fn drive_that_is_interrupted_while_a_global_planner_plans_replays_with_the_same_bits() {
    let place = with_person();
    let each = format!("if [ $asked ]; then touch waits; sleep 100; fi; asked=1; {PATH}");
    script(&place, "plans.sh", &each);
    place.write("own.toml", "global_planner.command = [\"sh\", \"plans.sh\"]\n");
    let drive = format!("{DRIVE} --config own.toml --obstacles person.json --record drive.mcap");
    let (status, stdout, stderr) = place.interrupted(&drive, "waits");
    assert_eq!(status, 1, "{stdout}{stderr}");
    assert!(stdout.contains("the drive was interrupted"), "{stdout}{stderr}");
    let words = ["replay", "drive.mcap", "--engine", "cpu", "--json"];
    let given = [&words[..], &["--global-planner", "sh plans.sh"]].concat();
    let (status, object) = object(&place.run_words(&given));
    assert_eq!((status, &object["agree"]), (0, &json!(true)), "{object}");
}

/// A recording may be of another person.
#[test]
fn replay_runs_only_a_global_planner_that_is_given() {
    let place = Workplace::with_room();
    let answer = r#"echo '{"path": [[1, 1.5], [3, 2.5], [5, 1.5]]}'"#;
    script(&place, "plans.sh", &format!("touch ran; {answer}"));
    driven(&place, "--global-planner 'sh plans.sh' --record drive.mcap");
    fs::remove_file(place.path("ran")).expect("the program ran");
    let error = place.refusal("replay drive.mcap --engine cpu");
    assert!(error.contains("drive.mcap: ") && error.contains("`sh plans.sh`"), "{error}");
    assert!(error.contains("(--global-planner COMMAND)"), "{error}");
    assert!(!place.path("ran").exists());
    let replay = ["replay", "drive.mcap", "--engine", "cpu", "--json"];
    let given =
        |command| object(&place.run_words(&[&replay[..], &["--global-planner", command]].concat()));
    let (status, replayed) = given("sh plans.sh");
    assert_eq!((status, &replayed["agree"]), (0, &json!(true)), "{replayed}");
    assert!(place.path("ran").exists());
    let (status, replayed) = given("sh missing.sh");
    let message = text(&replayed["error"], "message");
    assert_eq!((status, message.matches("INVALID_PLANNER").count()), (2, 1), "{message}");
    driven(&place, "--record drive.mcap");
    let (status, replayed) = given("sh plans.sh");
    assert!(
        status == 2 && text(&replayed["error"], "message").contains("inbye's own"),
        "{replayed}"
    );
}
