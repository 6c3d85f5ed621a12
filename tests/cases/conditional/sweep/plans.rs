//! The values that a plan accepts, and the inputs that determine a cell.

use serde_json::Value;

use inbye::experiment::Plan;

use super::Test;
use super::plan_folder::{CELLS, PLAN, PlanFolder};
use crate::support::room;

pub const TESTS: &[Test] = &[
    ("the documented plan equals the default", documented),
    ("the key of a cell depends on content, not on names", content_decides),
    ("a changed plan reuses unchanged cells", reuse),
    ("an invalid plan is rejected with its remedy", refusals),
    ("a cell that cannot start is a failed row, and the sweep goes on", errors_are_rows),
    ("every kind of world is driven", kinds),
    ("a machine without the engine leaves the cell to other machines", no_engine),
];

fn documented() {
    let text = Plan::documented();
    let plan: Plan = toml::from_str(&text).expect("it can be read");
    assert_eq!(plan, Plan::default());
    let place = PlanFolder::new();
    assert_eq!(place.run("sweep --print-plan").stdout, text);
    place.write("default.toml", text);
    let cells = place.json("sweep default.toml --list");
    assert_eq!(cells["cells"].as_array().map(Vec::len), Some(3), "{cells}");
}

fn keys(place: &PlanFolder, plan: &str) -> Vec<String> {
    let listed = place.json(&format!("sweep {plan} --list"));
    let cells = listed["cells"].as_array().expect("a list");
    let key = |cell: &Value| cell["key"].as_str().expect("a key").to_owned();
    let mut keys: Vec<String> = cells.iter().map(key).collect();
    keys.sort();
    keys
}

fn content_decides() {
    let place = PlanFolder::new();
    let first = keys(&place, "plan.toml");
    assert_eq!(first.len(), CELLS);
    for (name, text) in [
        ("worlds.csv", "barn/worlds.csv"),
        ("worlds/world_003.csv", "barn/worlds/world_003.csv"),
        ("worlds/world_012.csv", "barn/worlds/world_012.csv"),
    ] {
        place.write(&format!("elsewhere/moved/{name}"), place.read(text));
    }
    // Names, the folder and the order of keys differ.
    let renamed = PLAN
        .replace("paper", "as_printed")
        .replace("\"barn\"\npath = \"barn\"", "\"barn\"\npath = \"moved\"")
        .replace("posts", "poles");
    place.write("elsewhere/other.toml", renamed);
    assert_eq!(keys(&place, "elsewhere/other.toml"), first);
    // A change of one digit of one cylinder changes the cells of that world.
    let moved =
        String::from_utf8(place.read("elsewhere/moved/worlds/world_003.csv")).expect("text");
    place.write("elsewhere/moved/worlds/world_003.csv", moved.replace("6.0", "6.1"));
    let changed = keys(&place, "elsewhere/other.toml");
    let shared = changed.iter().filter(|key| first.contains(key)).count();
    assert_eq!(shared, CELLS / 2);
    for (from, to) in [("0.4", "0.41"), ("[0, 1, 2]", "[0, 1, 3]"), ("16x32", "16x33")] {
        place.write("changed.toml", PLAN.replace(from, to));
        assert_ne!(keys(&place, "changed.toml"), first, "{to}");
    }
}

fn reuse() {
    let place = PlanFolder::done();
    place.write("more.toml", PLAN.replace("[0, 1, 2]", "[0, 1, 2, 3]"));
    let report = place.json("sweep more.toml --out out");
    assert_eq!(report["found"], CELLS, "{report}");
    assert_eq!(report["driven"], CELLS / 3, "{report}");
    // Two names of the same settings give one cell and two rows.
    let twice = PLAN.replace("[weights.paper]\n", "[weights.paper]\n[weights.too]\n");
    place.write("twice.toml", twice);
    // The list has a line for each cell, with both names.
    let listed = place.json("sweep twice.toml --list");
    let cells = listed["cells"].as_array().expect("a list");
    let names = |cell: &Value| [&cell["weights"], &cell["also"][0]["weights"]].map(Value::clone);
    let shared = cells.iter().filter(|cell| names(cell) == ["paper", "too"]).count();
    let alone = cells.iter().filter(|cell| cell.get("also").is_none()).count();
    assert_eq!((cells.len(), shared, alone), (CELLS, CELLS / 2, CELLS / 2), "{listed}");
    let report = place.json("sweep twice.toml --out out");
    assert_eq!((&report["cells"], &report["driven"]), (&CELLS.into(), &0.into()));
    place.json("sweep merge out --report merged");
    let lines = String::from_utf8(place.read("merged/sweep.csv")).expect("text");
    assert_eq!(lines.lines().count(), 1 + CELLS * 3 / 2, "{lines}");
}

fn refusals() {
    let place = PlanFolder::new();
    for (from, to, says) in [
        ("sampling =", "samplng =", "did you mean `sampling`?"),
        ("path =", "pth =", "did you mean `path`?"),
        ("velocity", "velocty", "did you mean `velocity`?"),
        ("\"8x16\"", "\"8*16\"", "write forward speeds x turn rates"),
        ("[0, 1, 2]", "[0, 1, 1]", "seeds has 1 more than once: name each value once"),
        ("[0, 1, 2]", "[]", "at least one"),
        ("kind = \"barn\"", "kind = \"burn\"", "did you mean `barn`?"),
        ("path = \"barn\"", "path = \"nowhere\"", "nowhere/worlds.csv"),
        ("path = \"barn\"", "path = \"barn\"\nonly = [4]", "world 4 is not among"),
        ("path = \"barn\"", "routes = []", "worlds.0.path is missing"),
        // Keys without an effect on worlds of this kind.
        (
            "path = \"barn\"",
            "path = \"barn\"\npeople = 9",
            "worlds.0.people is 9: it must be left out",
        ),
        ("path = \"barn\"", "path = \"barn\"\ntime_limit_s = 2", "worlds.0.time_limit_s is 2"),
        ("path = \"barn\"", "path = \"barn\"\nresolution_m = 0.5", "worlds.0.resolution_m is 0.5"),
        ("path = \"barn\"", "path = \"barn\"\nlongest_m = 5", "worlds.0.longest_m is 5"),
        ("path = \"barn\"", "path = \"barn\"\nunmapped_share = 1", "worlds.0.unmapped_share is 1"),
        (
            "kind = \"barn\"\npath = \"barn\"",
            "kind = \"scenes\"\nmax_speed_m_s = 1",
            "worlds.0.max_speed_m_s is 1",
        ),
        ("title", "engines = [\"auto\"]\ntitle", "a cell must name its engine"),
        ("velocity = 0.4", "velocity = -1.0", "weights.fast"),
        (
            "[weights.paper]",
            "[configs.a]\nnavigator = { deadline_s = 0.1 }\n[weights.paper]",
            "depends on the wall clock",
        ),
        (
            "[weights.paper]",
            "[configs.a]\nnavigator = { wait_for_plans = false }\n[weights.paper]",
            "depend on the wall clock",
        ),
        (
            "[weights.paper]",
            "[configs.a]\nlocal = { vx_smples = 3 }\n[weights.paper]",
            "did you mean `vx_samples`?",
        ),
    ] {
        let says = says.replace("depends on", "depend on");
        let plan = PLAN.replacen(from, to, 1);
        assert_ne!(plan, PLAN, "{from}");
        place.write("bad.toml", plan);
        let message = place.refusal("sweep bad.toml --out out");
        assert!(message.contains(&says) && message.contains("bad.toml"), "{to}: {message}");
    }
    for (arguments, says) in [
        ("sweep plan.toml --shard 3/2", "--shard"),
        ("sweep plan.toml --cell 00", "no cell of this plan"),
        ("sweep nowhere.toml", "nowhere.toml"),
        ("sweep", "PLAN.toml"),
        ("sweep merge nowhere", "nowhere/sweep.json"),
    ] {
        let message = place.refusal(arguments);
        assert!(message.contains(says), "{arguments}: {message}");
    }
}

fn errors_are_rows() {
    let place = PlanFolder::new();
    // 12 by 8 m in cells of 0.25 m, with a small closed room.
    place.write("room.txt", room::rows(48, 32, &[]).join("\n"));
    place.write("closet.txt", "#####\n#...#\n#...#\n#####\n");
    place.write(
        "routes.toml",
        "[[worlds]]\nkind = \"map\"\npath = \"room.txt\"\nresolution_m = 0.25\nroutes = [\n\
         { start = [3.0, 4.0, 0.0], goal = [8.0, 0.4] },\n{ start = [3.0, 4.0, 0.0], goal = [11.7, 4.0, 1.0] },\n\
         { start = [3.0, 4.0, 0.0], goal = [9.0, 4.0] },\n]\n\
         [[worlds]]\nkind = \"missions\"\npath = \"closet.txt\"\nresolution_m = 0.25\n",
    );
    let report = place.json("sweep routes.toml --out out");
    assert_eq!((&report["driven"], &report["errors"]), (&4.into(), &1.into()), "{report}");
    assert_eq!(report["faults"], serde_json::json!({ "GOAL_OCCUPIED": 2 }), "{report}");
    place.json("sweep merge out --report merged");
    let table = String::from_utf8(place.read("merged/sweep.csv")).expect("text");
    let rows: Vec<&str> = table.lines().skip(1).collect();
    assert_eq!(rows.len(), 4, "{table}");
    for (row, says) in rows.iter().zip([
        ",failed,,GOAL_OCCUPIED,\"GOAL_OCCUPIED",
        ",failed,,GOAL_OCCUPIED,",
        ",reached,",
        ",error,,,closet: no two free places",
    ]) {
        assert!(row.contains(says), "{says}: {row}");
    }
}

fn kinds() {
    let place = PlanFolder::new();
    place.write(
        "dynabarn/world_00.json",
        r#"{"world": 0, "start_x_y_yaw": [0, 0, 0], "goal_x_y": [6, 0], "obstacles":
            [{"radius_m": 0.3, "loop_s": 10, "keyframes_t_x_y": [[0, 3, 3], [5, 3, 6], [10, 3, 3]]}]}"#,
    );
    place.write(
        "kinds.toml",
        "[[worlds]]\nkind = \"dynabarn\"\npath = \"dynabarn\"\n\
         [[worlds]]\nkind = \"missions\"\nlongest_m = 8.0\npeople = 1\n",
    );
    place.write(
        "built_in.toml",
        "[[worlds]]\nkind = \"localization\"\n[[worlds]]\nkind = \"paper\"\n",
    );
    let listed = place.json("sweep built_in.toml --list");
    let worlds = listed["cells"].as_array().expect("a list").iter();
    let worlds: Vec<&str> = worlds.map(|cell| cell["world"].as_str().expect("a name")).collect();
    assert_eq!(worlds.len(), 10 + 3 * 3, "{listed}");
    assert_eq!((worlds[0], worlds[10]), ("roadway tour", "drift none"));
    let report = place.json("sweep kinds.toml --out out");
    assert_eq!((&report["cells"], &report["errors"]), (&5.into(), &0.into()), "{report}");
    let merged = place.json("sweep merge out --report merged");
    let kinds: Vec<&Value> =
        merged["groups"].as_array().expect("a list").iter().map(|group| &group["kind"]).collect();
    assert_eq!(kinds, ["dynabarn", "missions"]);
    for picture in ["groups-dynabarn.svg", "groups-missions.svg"] {
        let text = String::from_utf8(place.read(&format!("merged/{picture}"))).expect("text");
        roxmltree::Document::parse(&text).expect("a picture");
    }
}

fn no_engine() {
    let place = PlanFolder::new();
    place.write(
        "gpu.toml",
        PLAN.replacen("title", "engines = [\"cpu\", \"gpu:none such\"]\ntitle", 1),
    );
    let ran = place.run("sweep gpu.toml --out out --json");
    assert_eq!(ran.status, 1, "{ran:?}");
    let report: Value = serde_json::from_str(&ran.stdout).expect("JSON");
    assert_eq!(report["driven"], CELLS, "{report}");
    assert_eq!(report["left"].as_array().map(Vec::len), Some(CELLS), "{report}");
    assert_eq!(place.finished("out").len(), CELLS);
}
