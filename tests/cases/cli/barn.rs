//! `inbye bench barn`.

use std::fs;

use serde_json::{Value, json};

use super::program::{Workplace, assert_fields};

const LIST: &str = "world,official50,path_length_m,optimal_time_s,dwa_success,dwa_collision,dwa_timeout,dwa_metric\n\
    3,1,10.0,5.0,0.90,0.10,0.00,0.1500\n\
    12,0,10.0,5.0,,,,\n";
/// Posts beside the straight way, and in it.
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

/// The rows of a record without what the wall clock says.
fn timeless(text: &str) -> Vec<String> {
    let without_clock = |line: &str| {
        let fields: Vec<&str> = line.split(',').collect();
        let mut kept = fields[..fields.len() - 3].to_vec();
        kept.push(fields[fields.len() - 1]);
        kept.join(",")
    };
    text.lines().map(without_clock).collect()
}

#[test]
fn worlds_are_driven() {
    let place = place();
    let (status, object) = place.json(&format!("{BENCH} --seeds 2 --threads 2 --record runs.csv"));
    assert_eq!(status, 0);
    assert_fields(
        &object,
        "worlds whole, runs whole, success real, collided whole, timeout whole, failed whole, score real, \
         mean_time_s real, max_speed real, simulator text, rows list, official.score real, published.score real, \
         rows[].world whole, rows[].seed whole, rows[].result text, rows[].time_s real, rows[].travelled_m real, \
         rows[].min_clearance_m real, rows[].optimal_time_s real, rows[].score real, rows[].fault null, \
         rows[].decision_p50_ms real, rows[].decision_p99_ms real",
    );
    assert_eq!(
        (&object["worlds"], &object["runs"]),
        (&json!(2), &json!(4)),
        "{object}"
    );
    assert_eq!(object["success"], json!(1.0), "{object}");
    assert_eq!(object["published"]["score"], json!(0.15));
    let keys = |object: &Value| -> Vec<(u64, u64)> {
        let key = |row: &Value| {
            (
                row["world"].as_u64().unwrap(),
                row["seed"].as_u64().unwrap(),
            )
        };
        object["rows"].as_array().unwrap().iter().map(key).collect()
    };
    assert_eq!(keys(&object), [(3, 0), (3, 1), (12, 0), (12, 1)]);
    let (_, one) = place.json(&format!("{BENCH} --only 12"));
    assert_eq!(keys(&one), [(12, 0)]);
    assert_eq!(one["published"], json!(null));

    let run = place.run(&format!("{BENCH} --only 3 --max-speed 0.5"));
    assert_eq!((run.status, run.errors.len()), (0, 0), "{run:?}");
    assert!(run.stdout.contains("here, 0.5 m/s at most"), "{run:?}");
    assert!(run.stdout.contains("not Gazebo"), "{run:?}");
}

#[test]
fn a_campaign_goes_on_where_it_was_cut_short() {
    let place = place();
    let bench =
        |threads: usize| format!("{BENCH} --seeds 2 --threads {threads} --record runs.csv --json");
    let read = || fs::read_to_string(place.path("runs.csv")).expect("a record");
    assert_eq!(place.run(&bench(3)).status, 0);
    let whole = read();
    assert_eq!(whole.lines().count(), 5, "{whole}");
    // Cut within the third row: the first two are kept as they are, the others are run again.
    let second_end = whole.match_indices('\n').nth(2).expect("five lines").0 + 1;
    place.write("runs.csv", &whole[..second_end + 9]);
    assert_eq!(place.run(&bench(1)).status, 0);
    let again = read();
    assert!(again.starts_with(&whole[..second_end]), "{again}");
    assert_eq!(timeless(&again), timeless(&whole));
    // Nothing is left to do, and nothing is changed.
    assert_eq!(place.run(&bench(2)).status, 0);
    assert_eq!(read(), again);
    let refusal = place.refusal(&format!("{BENCH} --max-speed 1 --record runs.csv"));
    assert!(
        refusal.contains("runs.csv: line 2 was run with other settings"),
        "{refusal}"
    );
    assert_eq!(read(), again);
}

#[test]
fn a_run_is_drawn_and_told_tick_by_tick() {
    let place = place();
    let (status, row) = place.json(&format!(
        "{BENCH} --trace 12,4 --svg run.svg --ticks run.jsonl"
    ));
    assert_eq!(status, 0);
    assert_eq!((&row["world"], &row["seed"]), (&json!(12), &json!(4)));
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
fn settings_of_a_file_take_the_place_of_ours() {
    let place = place();
    place.write("slow.toml", "[robot.limits]\nmax_vel_x = 0.4\n");
    let (_, object) = place.json(&format!("{BENCH} --only 3 --config slow.toml"));
    let time_s = object["rows"][0]["time_s"].as_f64().expect("a time");
    // 9 m at 0.4 m/s.
    assert!(time_s > 22.0, "{object}");
}

#[test]
fn what_means_nothing_is_refused() {
    let place = place();
    place.write("typo.toml", "[navigator]\nlookahed_m = 1.0\n");
    place.write("bad.toml", "[local]\nsim_time_s = -1.0\n");
    place.write("rows.csv", "something,else\n");
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
--worlds barn --record rows.csv -> rows.csv: line 1 is no header
--worlds barn --record gone/rows.csv -> --record gone/rows.csv; folder that exists
--worlds barn --svg run.svg -> --trace
--worlds barn --trace 3 -> --trace; WORLD,SEED
--worlds barn --trace 4,0 -> world 4 is not among
--worlds barn --trace 3,0 --svg run.png -> --svg run.png; .svg
--worlds barn --trace 3,0 --seeds 2 -> --trace; --seeds
";
    for line in table.lines().filter(|line| !line.is_empty()) {
        let (arguments, words) = line.split_once(" -> ").expect("a line has an arrow");
        let refusal = place.refusal(&format!("bench barn {arguments}"));
        for word in words.split("; ") {
            assert!(
                refusal.contains(word),
                "{arguments}: no {word:?} in: {refusal}"
            );
        }
    }
    let rows = fs::read_to_string(place.path("rows.csv")).expect("it is there");
    assert_eq!(rows, "something,else\n");
}
