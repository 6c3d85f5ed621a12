//! `inbye tune`.

use serde_json::{Value, json};

use super::program::Workplace;

/// A room of 6 by 3 m, one way for the search and the way back for the judgement.
fn place() -> Workplace {
    let place = Workplace::with_room();
    let worlds = |name: &str, route: &str| {
        format!(
            "[[{name}]]\nkind = \"map\"\npath = \"../room.txt\"\nresolution_m = 0.2\nroutes = [{route}]\n"
        )
    };
    let plan = [
        "rounds = 2\ncandidates = 2\n[space]\n\"local.vx_samples\" = { from = 2, to = 12 }\n",
        &worlds("train", "{ start = [1, 1.5, 0], goal = [5, 1.5] }"),
        &worlds("judge", "{ start = [5, 1.5, 3.1], goal = [1, 1.5] }"),
    ];
    place.write("plans/plan.toml", plan.concat());
    place
}

/// What a search found, without what depends on the machine.
fn answer(object: &Value) -> Value {
    json!([object["changes"], object["train"], object["judge"], object["candidates"]])
}

#[test]
fn search_judges_its_best_settings_on_other_worlds_and_saves_them() {
    let place = place();
    let (status, object) = place.json("tune plans/plan.toml --save tuned.toml");
    assert_eq!(status, 0, "{object}");
    // Two candidates in each of two rounds, and the settings without changes.
    let candidates = object["candidates"].as_array().expect("a list");
    assert_eq!(candidates.len(), 5, "{object}");
    let success = |candidate: &Value| candidate["success"].as_f64().expect("a number");
    assert!(candidates.windows(2).all(|two| success(&two[0]) >= success(&two[1])), "{object}");
    assert_eq!(object["train"]["tuned"], candidates[0]["success"]);
    assert!(object["judge"]["tuned"].as_f64() > Some(0.3), "{object}");
    let saved = std::fs::read_to_string(place.path("tuned.toml")).expect("the file");
    let changes = object["changes"].as_str().expect("a text");
    assert!(saved.starts_with("# Found by `inbye tune`") && saved.ends_with(changes), "{saved}");
    // The same command may replace its file; the settings are those that --config reads.
    assert_eq!(place.run("tune plans/plan.toml --save tuned.toml").status, 0);
    assert_eq!(place.run("config --check tuned.toml").status, 0);
}

/// A runner is another sweep here; on a cluster it is `examples/sweep_ray.py`, which takes the same arguments.
#[cfg(unix)]
#[test]
fn runner_runs_all_cells_and_the_answer_is_the_same() {
    let place = place();
    let (_, alone) = place.json("tune plans/plan.toml");
    let inbye = env!("CARGO_BIN_EXE_inbye");
    place.write("run.sh", format!("'{inbye}' sweep \"$@\" >&2 && ls \"$3/cells\" >>ran\n"));
    let words = ["tune", "plans/plan.toml", "--out", "out", "--runner", "sh run.sh", "--json"];
    let run = place.run_words(&words);
    let object: Value = serde_json::from_str(&run.stdout).expect("standard output is JSON");
    assert_eq!((run.status, answer(&object)), (0, answer(&alone)), "{run:?}");
    let ran = std::fs::read_to_string(place.path("ran")).expect("what the runner did");
    // The runs of the search, and two of the judgement unless the settings without changes are the best.
    assert!((5..=7).contains(&ran.lines().count()), "{ran}");
}

#[test]
fn runner_that_fails_is_named_and_one_without_a_folder_is_refused() {
    let place = place();
    let refusal = place.refusal("tune plans/plan.toml --out out --runner false");
    assert!(refusal.contains("--runner false: exit status: 1"), "{refusal}");
    let refusal = place.refusal("tune plans/plan.toml --out out --runner ./missing");
    assert!(refusal.contains("--runner ./missing: cannot be started"), "{refusal}");
    let refusal = place.refusal("tune plans/plan.toml --runner false");
    assert!(refusal.contains("--out"), "{refusal}");
}

#[test]
fn space_without_valid_settings_is_refused_with_the_reason() {
    let place = place();
    let plan = std::fs::read_to_string(place.path("plans/plan.toml")).expect("the plan");
    for (name, range, words) in [
        ("local.vx_sampels", "from = 2, to = 12", "did you mean `vx_samples`?"),
        ("robot.limits.acc_lim_x", "from = -2, to = -1", "[robot.limits] acc_lim_x"),
        ("local.stopping", "values = [\"arcs\"]", "did you mean `arc`?"),
    ] {
        let other = plan.replace("local.vx_samples", name).replace("from = 2, to = 12", range);
        place.write("plans/other.toml", other);
        let refusal = place.refusal("tune plans/other.toml");
        assert!(refusal.contains(&format!(": space.{name}: ")), "{refusal}");
        assert!(refusal.contains(words), "{name}: {refusal}");
    }
}

#[cfg(unix)]
#[test]
fn interrupted_search_prints_one_object_with_what_it_has() {
    let place = place();
    let plan = std::fs::read_to_string(place.path("plans/plan.toml")).expect("the plan");
    let long = plan.replace("rounds = 2\ncandidates = 2", "rounds = 100\ncandidates = 20");
    place.write("plans/long.toml", long);
    let command = "tune plans/long.toml --json --out out --threads 1 --save tuned.toml";
    let (status, stdout, stderr) = place.interrupted(command, "out/round-1/cells");
    assert_eq!((status, stdout.lines().count()), (1, 1), "{stdout}{stderr}");
    let object: Value = serde_json::from_str(&stdout).expect("JSON");
    assert_eq!(object["interrupted"], true, "{object}");
    assert!(object["candidates"].as_array().is_some_and(|all| all.len() >= 21), "{object}");
    assert!(object["changes"].is_string() && object["train"]["tuned"].is_number(), "{object}");
    assert_eq!([&object["judge"], &object["ranked"]], [&Value::Null, &json!([])], "{object}");
    assert!(!place.path("tuned.toml").exists(), "settings that are not judged are not saved");
}

/// A search for a robot starts from the settings of that robot.
#[test]
fn search_starts_from_the_settings_of_the_plan_and_saves_them_too() {
    let place = place();
    let plan = std::fs::read_to_string(place.path("plans/plan.toml")).expect("the plan");
    let own =
        "[config]\nrobot.limits.max_vel_x = 0.3\n[config.navigator]\nlookahead_m = 2.5\n[space]";
    let space = "\"robot.limits.max_vel_x\" = { from = 0.3, to = 0.31 }";
    let plan = plan.replace("\"local.vx_samples\" = { from = 2, to = 12 }", space);
    place.write("plans/own.toml", plan.replace("[space]", own));
    let run =
        place.run("tune plans/own.toml --save tuned.toml --record rows.json --report page --json");
    assert_eq!(run.status, 0, "{run:?}");
    let object: Value = serde_json::from_str(&run.stdout).expect("standard output is JSON");
    let rows = std::fs::read_to_string(place.path("rows.json")).expect("rows");
    let rows: Vec<Value> = serde_json::from_str(&rows).expect("rows");
    // 4 m at 0.3 m/s: the robot is measured against its own speed, not that of the default robot.
    for row in &rows {
        let ideal_s = row["ideal_time_s"].as_f64().expect("a time");
        assert!((13.0..14.0).contains(&ideal_s), "{row}");
        assert!(row["time_s"].as_f64() >= Some(ideal_s), "{row}");
    }
    let saved = std::fs::read_to_string(place.path("tuned.toml")).expect("the file");
    let saved: toml::Table = saved.parse().expect("TOML");
    let tuned = saved["robot"]["limits"]["max_vel_x"].as_float().expect("a number");
    assert!(tuned > 0.3 && tuned < 0.31, "{saved}");
    assert_eq!(saved["navigator"]["lookahead_m"].as_float(), Some(2.5), "{saved}");
    assert_eq!(place.run("config --check tuned.toml").status, 0);
    // The page shows what was tuned, and the gain on both sets of worlds.
    let page = std::fs::read_to_string(place.path("page/index.html")).expect("a page");
    assert!(page.contains("<h2>Tuned settings</h2>"), "{page}");
    for worlds in ["train", "judge"] {
        for settings in ["default", "tuned"] {
            let success = object[worlds][settings].as_f64().expect("a number");
            assert!(page.contains(&format!("<td>{success:.3}</td>")), "{worlds} {settings}");
        }
    }
    let changes = object["changes"].as_str().expect("a text");
    assert_eq!(changes, format!("robot.limits.max_vel_x = {tuned}\n"));
    assert!(page.contains(&format!("<pre>{}</pre>", changes.trim_end())), "{page}");
    assert!(page.contains("overfitting"), "{page}");
    place.write("plans/own.toml", plan.replace("[space]", "[config]\nlocal.sampels = 1\n[space]"));
    let refusal = place.refusal("tune plans/own.toml");
    assert!(refusal.contains("config: unknown field `sampels`"), "{refusal}");
}

#[test]
fn unusable_range_is_shown_as_written() {
    let place = place();
    let plan = std::fs::read_to_string(place.path("plans/plan.toml")).expect("the plan");
    place.write("plans/turned.toml", plan.replace("from = 2, to = 12", "from = 12, to = 2"));
    let refusal = place.refusal("tune plans/turned.toml");
    let shown = "plans/turned.toml: line 4, `\"local.vx_samples\" = { from = 12, to = 2 }`: \
        space.local.vx_samples is { from = 12, to = 2 }: it must be { from = LESS, to = MORE }";
    assert!(refusal.contains(shown), "{refusal}");
}

#[test]
fn unusable_space_is_refused_at_its_line() {
    let place = place();
    let plan = std::fs::read_to_string(place.path("plans/plan.toml")).expect("the plan");
    let range = "{ from = 2, to = 12 }";
    assert!(plan.contains(range));
    for (value, expected) in [
        (
            "[8, 16]",
            "line 4, `\"local.vx_samples\" = [8, 16]`: invalid type: sequence, expected a table",
        ),
        ("{ values = [] }", "space.local.vx_samples is without values: it must be { from = LESS"),
        (
            "{ values = [-8, 16] }",
            "line 4, `\"local.vx_samples\" = { values = [-8, 16] }`: space.local.vx_samples: -8: ",
        ),
    ] {
        place.write("plans/bad.toml", plan.replace(range, value));
        let refusal = place.refusal("tune plans/bad.toml");
        assert!(refusal.contains(expected), "{value}: {refusal}");
    }
}

/// Without the reason, a goal off the map would look like settings that gain nothing.
#[test]
fn search_without_an_arrival_names_the_faults_and_has_exit_status_one() {
    let place = place();
    let plan = std::fs::read_to_string(place.path("plans/plan.toml")).expect("the plan");
    place.write("plans/off.toml", plan.replace("goal = [1, 1.5]", "goal = [1, 2.75]"));
    let run = place.run("tune plans/off.toml");
    assert_eq!(run.status, 1, "{run:?}");
    let has = |line: &str| run.stdout.lines().any(|other| other == line);
    assert!(has("other worlds: no run reached its goal"), "{run:?}");
    assert!(run.stdout.contains("\nother worlds: faults: GOAL_OCCUPIED: "), "{run:?}");
    assert!(!run.stdout.contains("search: "), "{run:?}");
    place.write("plans/off.toml", plan.replace("goal = [5, 1.5]", "goal = [5, 2.75]"));
    let (status, object) = place.json("tune plans/off.toml");
    assert_eq!((status, &object["faults"]["judge"]), (1, &Value::Null), "{object}");
    // Two candidates in each of two rounds, and the settings without changes.
    assert_eq!(object["faults"]["train"], "GOAL_OCCUPIED: 5", "{object}");
    // A goal that no robot can reach is an error of the plan.
    place.write("plans/off.toml", plan.replace("goal = [5, 1.5]", "goal = [5, 99]"));
    let refusal = place.refusal("tune plans/off.toml");
    assert!(refusal.contains("the goal (5.00, 99.00) of a route is outside the map"), "{refusal}");
}

#[test]
fn world_of_the_search_cannot_judge() {
    let place = place();
    let plan = std::fs::read_to_string(place.path("plans/plan.toml")).expect("the plan");
    let route = "{ start = [5, 1.5, 3.1], goal = [1, 1.5] }";
    place.write("plans/same.toml", plan.replace("{ start = [1, 1.5, 0], goal = [5, 1.5] }", route));
    let refusal = place.refusal("tune plans/same.toml");
    assert!(refusal.contains("judge: world room route 1 of map is in train too"), "{refusal}");
}

#[test]
fn printed_plan_has_a_value_for_every_key() {
    let text = place().run("tune --print-plan").stdout;
    let judge = text.split_once("[[judge]]").expect("the worlds of the judgement").1;
    for line in ["kind = \"scenes\"", "only = []", "people = 0", "# path = \"maps/mine.yaml\""] {
        assert!(judge.lines().any(|found| found == line), "no {line:?} in: {judge}");
    }
    assert!(text.lines().all(|line| !line.trim_end().ends_with('=')), "{text}");
}

#[test]
fn help_says_which_runs_are_recorded() {
    let help = place().run("tune --help").stdout;
    let help = help.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(help.contains("--record <FILE> Write a row for each run of the judgement"), "{help}");
}
