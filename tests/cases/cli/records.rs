//! `inbye bench draw`, and the pages of benchmarks.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use roxmltree::Document;
use serde_json::{Value, json};

use super::program::Workplace;

const RECORDS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/records/two-shared-xeon-cores");

/// Some columns of runs: the others may be missing.
const RUNS: &str =
    "kind,world,seed,outcome,contact_cause,time_s,travelled_m,optimal_time_s,score,reason\n";

/// A few rows of each kind; the oldest latencies have neither names nor misses.
pub fn write_records(place: &Workplace) {
    place.write(
        "latency.csv",
        "engine,adapter,threads,samples,steps,p50_ms,p95_ms,p99_ms,max_ms,decisions,steps_per_s\n\
         cpu,\"\",1,256,40,0.06,0.07,0.09,0.14,5000,160000000.5\n\
         cpu,\"\",1,1024,40,0.24,0.4,0.44,0.5,5000,170000000.5\n\
         gpu,\"llvmpipe (LLVM 15.0.6, 256 bits)\",0,256,40,0.8,0.9,0.93,1.5,673,12650237\n",
    );
    place.write(
        "barn.csv",
        &(RUNS.to_owned()
            + "barn,3,0,reached,,8.0,9.3,5.0,0.5,\n\
               barn,3,1,reached,,20.0,9.3,5.0,0.25,\n\
               barn,12,0,failed,,60.0,9.3,5.0,0.0,\"NO_VALID_CONTROL: nothing, at all\"\n"),
    );
    place.write(
        "dynabarn.csv",
        &(RUNS.to_owned()
            + "dynabarn,0,0,reached,,10.9,19.0,,,\n\
               dynabarn,2,0,contact,avoidable,6.0,9.0,,,\n"),
    );
}

fn place() -> Workplace {
    let place = Workplace::new();
    write_records(&place);
    place
}

#[test]
fn draw_shows_several_records() {
    let place = place();
    let (status, object) = place.json("bench draw latency.csv barn.csv dynabarn.csv --svg all.svg");
    assert_eq!(status, 0);
    assert_eq!(
        object["records"],
        json!([
            { "file": "latency.csv", "title": "latencies" },
            { "file": "barn.csv", "title": "BARN runs" },
            { "file": "dynabarn.csv", "title": "DynaBARN runs" },
        ])
    );
    let picture = fs::read_to_string(place.path("all.svg")).expect("a picture");
    Document::parse(&picture).expect("sound markup");
    for drawn in [
        "CPU, 1 thread",
        "llvmpipe (LLVM 15.0.6, 256 bits)",
        "world 3: 2 of 2 runs reached the goal, in 8.0 to 20.0 s",
        "world 12: 0 of 1 runs reached the goal",
        "avoidable contact caused by an obstacle",
    ] {
        assert!(picture.contains(drawn), "{drawn}");
    }
}

/// The rows of a drawn record are those of the record, and a page says where they are from.
#[test]
fn draw_report_has_its_rows_in_files() {
    let place = place();
    let run = place.run("bench draw latency.csv barn.csv --report out/deep");
    assert_eq!(run.status, 0, "{run:?}");
    assert_eq!(run.errors, ["report: out/deep/index.html"]);
    assert_eq!(
        names(&place, "out/deep"),
        [
            "barn.csv",
            "barn.json",
            "barn.svg",
            "index.html",
            "latency.csv",
            "latency.json",
            "latency.svg"
        ]
    );
    let read = |name: &str| fs::read_to_string(place.path(name)).expect("a file of the report");
    let page = read("out/deep/index.html");
    for message in [
        "inbye bench draw latency.csv barn.csv --report out/deep",
        "latency.csv (latencies)",
        "href=\"barn.json\"",
        "success 0.500, 0 collisions, score 0.1875 of 0.5",
    ] {
        assert!(page.contains(message), "{message}");
    }
    assert!(!page.contains("Measured on"), "no record names its machine");
    let rows: Value = serde_json::from_str(&read("out/deep/barn.json")).expect("JSON");
    assert_eq!(rows[1]["score"], json!(0.25));
    assert_eq!(rows[2]["reason"], json!("NO_VALID_CONTROL: nothing, at all"));
    // What is written is read again, and gives the same picture.
    let again = place.run("bench draw out/deep/barn.csv --svg again.svg");
    assert_eq!(again.status, 0, "{again:?}");
    assert_eq!(read("again.svg"), read("out/deep/barn.svg"));
}

#[test]
fn page_names_the_machine_that_a_record_names() {
    let place = place();
    let header = "kind,world,seed,outcome,time_s,latency,machine\n";
    place.write("here/runs.csv", format!("{header}barn,3,0,reached,8.0,true,a mill\n"));
    assert_eq!(place.run("bench draw here/runs.csv --report out").status, 0);
    let page = fs::read_to_string(place.path("out/index.html")).expect("the page");
    assert!(page.contains("Measured on: a mill<"), "{page}");
}

/// The committed soak: what its file says of ends is what the chart says, by map, and every mission that did not arrive is
/// reported with its reason.
#[test]
fn draw_groups_a_soak_by_map_and_traffic() {
    let place = Workplace::new();
    let record = format!("{RECORDS}/soak-2026-11-21.csv");
    let run = place.run(&format!("bench draw {record} --report out"));
    assert_eq!(run.status, 0, "{run:?}");
    assert_eq!(names(&place, "out"), ["index.html", "soak.csv", "soak.json", "soak.svg"]);
    let read = |name: &str| fs::read_to_string(place.path(&format!("out/{name}"))).expect("a file");
    let (page, picture) = (read("index.html"), read("soak.svg"));
    let rows: Vec<Value> = serde_json::from_str(&read("soak.json")).expect("a list");
    assert_eq!(rows.len(), 1000);
    let document = Document::parse(&picture).expect("sound markup");
    let titles = document.descendants().filter(|node| node.has_tag_name("title"));
    let reported: BTreeSet<&str> = titles.filter_map(|node| node.text()).collect();
    let counted = |label: &str, is: &dyn Fn(&Value) -> bool| {
        let of: Vec<&Value> = rows.iter().filter(|row| is(row)).collect();
        let reached = of.iter().filter(|row| row["outcome"] == "reached").count();
        let line = format!("{label}: {reached} of {} reached", of.len());
        assert!(reported.contains(&line[..]), "{line} in {reported:?}");
    };
    counted("all missions", &|_| true);
    counted("pedestrians that ignore the robot", &|row| row["traffic"] == "non_yielding");
    let maps: BTreeSet<&str> = rows.iter().filter_map(|row| row["world"].as_str()).collect();
    assert_eq!(maps.len(), 8);
    for map in maps {
        counted(map, &|row| row["world"] == map);
    }
    // One of each kind that occurs in the legend; no contact was the robot's.
    assert!(picture.contains("contact caused by an obstacle") && picture.contains("timeout"));
    assert!(!picture.contains("<rect class=\"end-contact\""));
    for row in rows.iter().filter(|row| row["outcome"] != "reached") {
        let reason = row["reason"].as_str().expect("a sentence");
        assert!(page.contains(&format!("<td>{reason}</td>")), "{reason}");
    }
    // What is written is read again, and gives the same picture.
    let again = place.run("bench draw out/soak.csv --svg out/again.svg");
    assert_eq!(again.status, 0, "{again:?}");
    assert_eq!(read("again.svg"), picture);
}

fn names(place: &Workplace, folder: &str) -> Vec<String> {
    let entries = fs::read_dir(place.path(folder)).expect("a folder");
    let names: BTreeSet<String> = entries
        .map(|entry| entry.expect("an entry").file_name())
        .map(|name| name.to_string_lossy().into_owned())
        .collect();
    names.into_iter().collect()
}

#[test]
fn benchmarks_write_pages() {
    let place = Workplace::new();
    super::barn::write_worlds(&place);
    super::dynabarn::write_worlds(&place);
    for (command, chart) in [
        ("barn --worlds barn --seeds 2", "barn"),
        ("dynabarn --worlds dynabarn", "dynabarn"),
        ("density --max-samples 1024 --seconds 0.01 --ticks 2 --missions 0", "quality"),
    ] {
        let run = place.run(&format!("bench {command} --report {chart}"));
        assert_eq!(run.status, 0, "{run:?}");
        assert_eq!(run.errors, [format!("report: {chart}/index.html")]);
        let read = |ending: &str| {
            let file = place.path(&format!("{chart}/{chart}.{ending}"));
            fs::read_to_string(file).expect("next to the page")
        };
        Document::parse(&read("svg")).expect("sound markup");
        let rows: Vec<Value> = serde_json::from_str(&read("json")).expect("a list");
        assert_eq!(read("csv").lines().count(), 1 + rows.len());
        let page = fs::read_to_string(place.path(&format!("{chart}/index.html"))).expect("a page");
        assert!(page.contains(&format!("inbye bench {command}")), "{command}");
        assert!(page.contains("Measured on: "), "{command}");
    }
}

#[test]
fn draw_rejects_files_that_are_no_records() {
    let place = place();
    let latency = fs::read_to_string(place.path("latency.csv")).expect("it is there");
    place.write("typo.csv", latency.replace(",0.24,", ",much,"));
    place.write("short.csv", latency.replace(",0.24,", ","));
    place.write("bare.csv", latency.lines().next().expect("a header"));
    place.write("other.csv", "map,queries,search\nmine,3,astar\n");
    place.write("none.csv", "");
    place.write("rows.json", "[\n  {\n    \"samples\": 1,\n    \"window_s\": 0.1\n  }\n]\n");
    let table = "
latency.csv -> --svg FILE.svg or --report DIR
 --svg a.svg -> RECORD.csv
gone.csv --svg a.svg -> gone.csv: cannot be read; check the path
typo.csv --svg a.svg -> typo.csv: line 3: p50_ms: invalid float
short.csv --svg a.svg -> short.csv: line 3: 10 fields; expected 11
bare.csv --svg a.svg -> bare.csv: holds no row
other.csv --svg a.svg -> other.csv: line 1 has not the columns
none.csv --svg a.svg -> none.csv: line 1 has not the columns
mine.png --svg a.svg -> mine.png: line 1
rows.json --svg a.svg -> rows.json: it is a JSON record; a CSV record
latency.csv latency.csv --svg a.svg -> latency.csv: a second record of latencies
latency.csv --svg a.png -> --svg a.png; .svg
latency.csv --report mine.png -> --report mine.png; another name
";
    for line in table.lines().filter(|line| !line.is_empty()) {
        let (arguments, words) = line.split_once(" -> ").expect("a line has an arrow");
        let refusal = place.refusal(&format!("bench draw {arguments}"));
        for word in words.split("; ") {
            assert!(refusal.contains(word), "{arguments}: no {word:?} in: {refusal}");
        }
    }
}

/// The book's page with the commands that draw its pictures.
const RESULTS: &str = "docs/src/results.md";

#[test]
fn pictures_of_the_book_equal_what_its_commands_draw() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = fs::read_to_string(root.join(RESULTS)).expect("the page of results");
    let commands: Vec<&str> =
        page.lines().filter(|line| line.starts_with("inbye ") && line.contains(".svg")).collect();
    let pictures = fs::read_dir(root.join("docs/src/pictures")).expect("the book's pictures");
    let names = pictures.map(|picture| picture.expect("a picture").file_name());
    let drawn = names.filter(|name| name.to_string_lossy().ends_with(".svg")).count();
    assert_eq!(commands.len(), drawn);
    let place = Workplace::new();
    for command in commands {
        let again = place.path("again.svg");
        let words: Vec<&str> = command.split_whitespace().skip(1).collect();
        let [arguments @ .., "--svg", picture] = &words[..] else {
            panic!("arguments and a picture: {command}");
        };
        let run = place
            .command()
            .args(arguments)
            .arg("--svg")
            .arg(&again)
            .current_dir(root)
            .output()
            .expect("the program starts");
        assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
        let again = fs::read_to_string(again).expect("a picture");
        let committed = fs::read_to_string(root.join(picture)).expect("a committed picture");
        assert!(again == committed, "draw it again: {command}");
    }
}
