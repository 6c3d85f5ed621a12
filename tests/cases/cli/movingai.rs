//! `inbye bench movingai`.

use std::fs;

use serde_json::{Value, json};

use super::program::{Workplace, assert_fields};

/// A wall with a way round its lower end.
const MAP: &str = "type octile\nheight 4\nwidth 5\nmap\n..@..\n..@..\n..T..\n.....\n";
/// Past the wall, along it, and nowhere.
const SCEN: &str = "version 1\n\
    1\troom.map\t5\t4\t0\t0\t4\t0\t8.82843\n\
    0\troom.map\t5\t4\t0\t0\t0\t3\t3\n\
    0\troom.map\t5\t4\t3\t1\t3\t1\t0\n";

const ALONE: &str = "bench movingai --map room.map --scen room.map.scen";
const FOLDER: &str = "bench movingai --folder maps";

fn place() -> Workplace {
    let place = Workplace::new();
    place.write("room.map", MAP);
    place.write("room.map.scen", SCEN);
    place.write("maps/one.map", MAP);
    place.write("maps/one.map.scen", SCEN);
    place.write("maps/below/two.map", MAP);
    place.write("maps/below/two.scen", SCEN.replace('\t', " "));
    place
}

/// The fields of an algorithm, in the object at a path that ends with a dot.
fn algorithm_fields(path: &str) -> String {
    let fields = [
        "name text",
        "exact bool",
        "solved whole",
        "total whole",
        "suboptimal whole",
        "illegal whole",
        "median_us real",
        "p95_us real",
        "max_us real",
        "expanded real",
        "mean_length_ratio real",
        "worst_length_ratio real",
        "first_fault null",
    ];
    fields.map(|field| format!("{path}algorithms[].{field}")).join(", ")
}

#[test]
fn a_map_is_measured() {
    let place = place();
    let (status, object) = place.json(ALONE);
    assert_eq!(status, 0);
    assert_fields(&object, "map text, scenarios whole, algorithms list");
    assert_fields(&object, &algorithm_fields(""));
    assert_eq!((&object["map"], &object["scenarios"]), (&json!("room.map"), &json!(3)));
    let names = |object: &Value| -> Vec<String> {
        let rows = object["algorithms"].as_array().expect("a list");
        for row in rows {
            let counts = ["solved", "total", "suboptimal", "illegal"].map(|key| &row[key]);
            assert_eq!(counts, [3, 3, 0, 0], "{row}");
        }
        rows.iter().map(|row| row["name"].to_string()).collect()
    };
    let (usual, all) = (names(&object), names(&place.json(&format!("{ALONE} --all")).1));
    assert!(usual.iter().all(|name| all.contains(name)), "{usual:?} of {all:?}");
    assert!(usual.len() >= 2 && all.len() > usual.len());
    let (_, longest) = place.json(&format!("{ALONE} --longest 1 --passes 3"));
    assert_eq!(longest["algorithms"][0]["total"], 1);
    assert_eq!(longest["scenarios"], 1);
    let run = place.run(ALONE);
    assert_eq!((run.status, run.errors.len()), (0, 0), "{run:?}");
    // The last line of the header begins with the name.
    let rows = run.stdout.lines().skip_while(|line| !line.starts_with("name")).skip(1);
    assert_eq!(rows.count(), usual.len(), "{run:?}");
    assert!(run.stdout.starts_with("room.map: 3 scenarios\n"), "{run:?}");
    assert!(run.stdout.contains(" 3      3 "), "{run:?}");
}

#[test]
fn a_folder_is_measured_map_by_map() {
    let place = place();
    let (status, object) = place.json(FOLDER);
    assert_eq!(status, 0);
    assert_fields(&object, "maps list, algorithms list, skipped list, maps[].map text");
    assert_fields(&object, &algorithm_fields(""));
    assert_fields(&object, &algorithm_fields("maps[]."));
    let names: Vec<&Value> =
        object["maps"].as_array().unwrap().iter().map(|map| &map["map"]).collect();
    assert_eq!(names, ["below/two.map", "one.map"]);
    assert_eq!(object["algorithms"][0]["total"], 6);
    assert_eq!(object["skipped"], json!([]));

    place.write("maps/bare.map", MAP);
    let run = place.run(&format!("{FOLDER} --json --record rows.csv"));
    assert_eq!(run.status, 0, "{run:?}");
    let [warning] = &run.errors[..] else {
        panic!("one warning: {run:?}");
    };
    assert!(warning.starts_with("warning: bare.map: left out"), "{warning}");
    let again: Value = serde_json::from_str(&run.stdout).expect("standard output is JSON");
    assert_eq!(again["skipped"], json!(["bare.map"]));
    let rows = 2 * object["algorithms"].as_array().unwrap().len();
    let table = fs::read_to_string(place.path("rows.csv")).expect("the record is there");
    let columns = |line: &str| line.split(',').count();
    assert!(table.starts_with("map,name,exact,solved,"), "{table}");
    assert_eq!(table.lines().count(), 1 + rows, "{table}");
    assert!(table.lines().all(|line| columns(line) == 14), "{table}");
    place.run(&format!("{FOLDER} --record rows.json"));
    let record = fs::read_to_string(place.path("rows.json")).expect("the record is there");
    let record: Vec<Value> = serde_json::from_str(&record).expect("the record is JSON");
    assert_eq!(record.len(), rows);
    assert_eq!((&record[0]["map"], &record[0]["solved"]), (&json!("below/two.map"), &json!(3)));
    let run = place.run(FOLDER);
    assert!(run.stdout.contains("\nall 2 maps: 6 scenarios\n"), "{run:?}");
}

#[test]
fn a_wrong_answer_is_told_by_the_exit_status() {
    let place = place();
    for (from, to, counts, message) in [
        // Legal paths whose listed length goes through the wall.
        ("8.82843", "7.82843", [3, 1, 0], "longer than the 7.82843 listed"),
        ("8.82843", "8.83843", [2, 0, 1], "shorter than the 8.83843 listed"),
        // A goal in the wall.
        ("\t4\t0\t8", "\t2\t0\t8", [2, 0, 0], "no path was found"),
    ] {
        place.write("room.map.scen", SCEN.replace(from, to));
        let (status, object) = place.json(ALONE);
        assert_eq!(status, 1, "{to}: {object}");
        let row = &object["algorithms"][0];
        assert_eq!(row["exact"], true);
        let found = ["solved", "suboptimal", "illegal"].map(|key| &row[key]);
        assert_eq!(found, counts, "{to}: {row}");
        let fault = row["first_fault"].as_str().expect("a fault");
        assert!(fault.starts_with("room.map, scenario of line 2: "), "{fault}");
        assert!(fault.contains(message), "{fault}");
        let run = place.run(ALONE);
        assert_eq!((run.status, run.errors.len()), (1, 0), "{run:?}");
        assert!(run.stdout.contains(&format!("WRONG: A* octile, first at {fault}")), "{run:?}");
    }
}

#[test]
fn files_that_mean_nothing_are_refused() {
    let place = place();
    place.write("empty.scen", "version 1\n\n");
    place.write("nine.scen", "version 1\n0\troom.map\t5\t4\t0\t0\t0\t3\n");
    place.write("word.scen", SCEN.replace("8.82843", "far"));
    place.write("size.scen", SCEN.replace("\t5\t4\t3\t1", "\t5\t6\t3\t1"));
    place.write("ragged.map", MAP.replace("..T..", "..T."));
    place.write("bare/room.map", MAP);
    place.write("nothing/readme.txt", "no map");
    let table = "
 -> --map; --help
--map room.map -> --scen
--scen room.map.scen -> --map
--folder maps --map room.map --scen room.map.scen -> --folder; --map
--map room.map --scen gone.scen -> gone.scen: cannot be read; check the path
--map gone.map --scen room.map.scen -> gone.map: cannot be read; check the path
--map room.map --scen empty.scen -> empty.scen: holds no scenario
--map room.map --scen nine.scen -> nine.scen: line 2; 8 fields; expected 9
--map room.map --scen word.scen -> word.scen: line 2; optimal is \"far\"
--map room.map --scen size.scen -> size.scen: line 4; 5 x 6; room.map has 5 x 4; name the scenarios
--map ragged.map --scen room.map.scen -> ragged.map: line 7; a row of 4 cells
--folder gone -> gone: the folder cannot be read; check the path
--folder room.map -> room.map: the folder cannot be read
--folder bare -> bare: no .map file; .map.scen
--folder nothing -> nothing: no .map file; .map.scen
--folder maps --longest 0 -> --longest; 1 to
--folder maps --passes 0 -> --passes; 1 to 1000
--folder maps --passes -1 -> --passes; 1 to 1000
--folder maps --record rows.txt -> --record rows.txt; .csv or .json
--folder maps --record gone/rows.csv -> --record gone/rows.csv; folder that exists
";
    for line in table.lines().filter(|line| !line.is_empty()) {
        let (arguments, words) = line.split_once(" -> ").expect("a line has an arrow");
        let refusal = place.refusal(&format!("bench movingai {arguments}"));
        for word in words.split("; ") {
            assert!(refusal.contains(word), "{arguments}: no {word:?} in: {refusal}");
        }
    }
    place.write("maps/below/two.scen", "0 two.map 5 4 0 0 9 9 1\n");
    let refusal = place.refusal(FOLDER);
    assert!(refusal.contains("two.scen: line 1: goal is (9, 9)"), "{refusal}");
}
