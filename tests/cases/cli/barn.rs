//! `inbye bench barn`.

use std::fs;

use serde_json::{Value, json};

use super::program::{Workplace, assert_fields};

const LIST: &str = "world,official50,path_length_m,optimal_time_s,dwa_success,dwa_collision,dwa_timeout,dwa_metric\n\
    3,1,10.0,5.0,0.90,0.10,0.00,0.1500\n\
    12,0,10.0,5.0,,,,\n";
/// Posts next to the straight path, and on it.
const THREE: &str = "x_m,y_m,radius_m,kind\n-1.5,6.0,0.075,obstacle\n";
const TWELVE: &str = "x_m,y_m,radius_m,kind\n-2.25,6.0,0.075,obstacle\n-2.4,6.0,0.075,obstacle\n-1.0,8.0,0.075,obstacle\n";

const BENCH: &str = "bench barn --worlds barn";

pub fn write_worlds(place: &Workplace) {
    place.write("barn/worlds.csv", LIST);
    place.write("barn/worlds/world_003.csv", THREE);
    place.write("barn/worlds/world_012.csv", TWELVE);
}

fn place() -> Workplace {
    let place = Workplace::new();
    write_worlds(&place);
    place
}

/// The rows of a record without what the wall clock says: the last columns.
fn timeless(text: &str) -> Vec<String> {
    let without_clock = |line: &str| {
        let fields: Vec<&str> = line.split(',').collect();
        fields[..fields.len() - 4].join(",")
    };
    text.lines().map(without_clock).collect()
}

#[test]
fn barn_drives_every_world_with_every_seed() {
    let place = place();
    let (status, object) = place.json(&format!("{BENCH} --seeds 2 --threads 2 --record runs.csv"));
    assert_eq!(status, 0);
    assert_fields(
        &object,
        "summary.all.worlds whole, summary.all.runs whole, summary.all.contacts whole, summary.all.timeouts whole, \
         summary.all.failed whole, summary.all.mean_time_s real, summary.over_worlds.success real, \
         summary.over_worlds.score real, summary.official.score real, summary.published.score real, max_speed real, \
         simulator text, rows list, rows[].kind text, rows[].world text, rows[].seed whole, rows[].outcome text, \
         rows[].time_s real, rows[].travelled_m real, rows[].min_clearance_m real, rows[].optimal_time_s real, \
         rows[].score real, rows[].fault null, rows[].trace_digest text, rows[].key text, rows[].tick_p50_ms real, \
         rows[].tick_p99_ms real",
    );
    let all = &object["summary"]["all"];
    assert_eq!((&all["worlds"], &all["runs"]), (&json!(2), &json!(4)), "{object}");
    let means = &object["summary"]["over_worlds"];
    assert_eq!(means["success"], json!(1.0), "{object}");
    assert_eq!(object["summary"]["published"]["score"], json!(0.15));
    let keys = |object: &Value| -> Vec<(String, u64)> {
        let key = |row: &Value| {
            let world = row["world"].as_str().expect("a name").to_owned();
            (world, row["seed"].as_u64().expect("a number"))
        };
        let rows = object["rows"].as_array().expect("a list");
        rows.iter().map(key).collect()
    };
    let key = |world: &str, seed| (world.to_owned(), seed);
    assert_eq!(keys(&object), [key("3", 0), key("3", 1), key("12", 0), key("12", 1)]);
    let (_, one) = place.json(&format!("{BENCH} --only 12"));
    assert_eq!(keys(&one), [key("12", 0)]);
    assert_eq!(one["summary"]["published"], json!(null));

    let run = place.run(&format!("{BENCH} --only 3 --max-speed 0.5"));
    assert_eq!((run.status, run.errors.len()), (0, 0), "{run:?}");
    assert!(run.stdout.contains("here, 0.5 m/s at most"), "{run:?}");
    assert!(run.stdout.contains("not Gazebo"), "{run:?}");
}

#[test]
fn barn_resumes_from_its_folder() {
    let place = place();
    let bench = |threads: usize| {
        format!("{BENCH} --seeds 2 --threads {threads} --out runs --record runs.csv --json")
    };
    let read = || fs::read_to_string(place.path("runs.csv")).expect("a record");
    assert_eq!(place.run(&bench(3)).status, 0);
    let whole = read();
    assert_eq!(whole.lines().count(), 5, "{whole}");
    // Two results are lost, and one is damaged by hand: that one is reported.
    let cells = || -> Vec<_> {
        let entries = fs::read_dir(place.path("runs/cells")).expect("a folder");
        let mut cells: Vec<_> = entries.map(|entry| entry.expect("an entry").path()).collect();
        cells.sort();
        cells
    };
    let kept = cells();
    assert_eq!(kept.len(), 4);
    for lost in &kept[..2] {
        fs::remove_file(lost).expect("it is there");
    }
    let before = fs::read(&kept[2]).expect("a result");
    assert_eq!(place.run(&bench(1)).status, 0);
    let again = read();
    assert_eq!(timeless(&again), timeless(&whole));
    assert_eq!(fs::read(&kept[2]).expect("a result"), before);
    // Nothing is left to do, and nothing changes.
    assert_eq!(place.run(&bench(2)).status, 0);
    assert_eq!(read(), again);
    // Other settings are other cells of the same folder.
    assert_eq!(place.run(&format!("{} --max-speed 1", bench(2))).status, 0);
    assert_eq!(cells().len(), 8);
    fs::write(&kept[2], "{}").expect("it can be written");
    let run = place.run(&bench(2));
    // A note on the cells of the other plan comes first.
    let error = run.errors.last().expect("an error");
    assert!(run.status == 2 && error.contains("damaged"), "{run:?}");
}

#[test]
fn barn_trace_draws_and_writes_one_run() {
    let place = place();
    let (status, row) =
        place.json(&format!("{BENCH} --trace 12,4 --svg run.svg --ticks run.jsonl"));
    assert_eq!(status, 0);
    assert_eq!((&row["world"], &row["seed"]), (&json!("12"), &json!(4)));
    let picture = fs::read_to_string(place.path("run.svg")).expect("a picture");
    let document = roxmltree::Document::parse(&picture).expect("sound markup");
    let class = |name: &str| {
        let has =
            |node: &roxmltree::Node| node.attribute("class").is_some_and(|it| it.contains(name));
        document.descendants().filter(has).count()
    };
    assert!(class("planned") > 1 && class("track") > 2, "{picture}");
    let ticks = fs::read_to_string(place.path("run.jsonl")).expect("ticks");
    let last: Value = serde_json::from_str(ticks.lines().last().unwrap()).expect("JSON");
    assert_eq!(last["time_s"], row["time_s"]);
}

#[test]
fn barn_config_file_changes_the_settings() {
    let place = place();
    place.write("slow.toml", "[robot.limits]\nmax_vel_x = 0.4\n");
    let (_, object) = place.json(&format!("{BENCH} --only 3 --config slow.toml"));
    let time_s = object["rows"][0]["time_s"].as_f64().expect("a time");
    // 9 m at 0.4 m/s.
    assert!(time_s > 22.0, "{object}");
}

#[test]
fn barn_rejects_bad_arguments_and_files() {
    let place = place();
    place.write("typo.toml", "[navigator]\nlookahed_m = 1.0\n");
    place.write("bad.toml", "[local]\nsim_time_s = -1.0\n");
    place.write("empty/worlds.csv", "world,path_length_m,optimal_time_s\n");
    place.write("nan/worlds.csv", LIST.replace("10.0,5.0", "10.0,NaN"));
    place.write("bare/worlds.csv", LIST);
    let table = "
 -> --worlds; --help
--worlds gone -> worlds.csv: cannot be read
--worlds empty -> worlds.csv: holds no world
--worlds nan -> worlds.csv: line 2: optimal_time_s is \"NaN\"
--worlds bare -> world_003.csv: cannot be read
--worlds barn --only 4 -> world 4 is not among the 2; 3, 12
--worlds barn --only x -> --only; a whole number
--worlds barn --seeds 0 -> --seeds; 1 to
--worlds barn --threads 0 -> --threads; 1 to 1024
--worlds barn --max-speed 0 -> --max-speed; above zero
--worlds barn --max-speed nan -> --max-speed; above zero
--worlds barn --config gone.toml -> gone.toml: cannot be read
--worlds barn --config typo.toml -> typo.toml; lookahed_m
--worlds barn --config bad.toml -> bad.toml; sim_time_s
--worlds barn --record runs.txt -> --record runs.txt; .csv
--worlds barn --record gone/rows.csv -> --record gone/rows.csv; folder that exists
--worlds barn --svg run.svg -> --trace
--worlds barn --only 3 --svg run.svg -> --trace
--worlds barn --seeds 2 --ticks run.jsonl -> --trace
--worlds barn --report page --ticks run.jsonl -> --trace
--worlds barn --trace 3 -> --trace; WORLD,SEED
--worlds barn --trace 4,0 -> world 4 is not among
--worlds barn --trace 3,0 --svg run.png -> --svg run.png; .svg
--worlds barn --trace 3,0 --seeds 2 -> --trace; --seeds
";
    for line in table.lines().filter(|line| !line.is_empty()) {
        let (arguments, words) = line.split_once(" -> ").expect("a line has an arrow");
        let refusal = place.refusal(&format!("bench barn {arguments}"));
        for word in words.split("; ") {
            assert!(refusal.contains(word), "{arguments}: no {word:?} in: {refusal}");
        }
    }
}
