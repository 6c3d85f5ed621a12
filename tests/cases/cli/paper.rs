//! `inbye bench paper`.

use std::fs;

use roxmltree::{Document, Node};
use serde_json::Value;

use super::program::{Workplace, assert_fields};

/// As quick as it gets without drives, on the folder's own map.
const QUICK: &str = "bench paper --mine mine.yaml --repetitions 2 --runs 0";

/// The same without what a clock has a hand in.
fn without_times(mut object: Value) -> Value {
    for table in object["tables"].as_array_mut().expect("a list") {
        let table = table.as_object_mut().expect("an object");
        table.remove("findings");
        table.remove("breakdowns");
        for list in ["rows", "reductions"] {
            for row in table.get_mut(list).and_then(Value::as_array_mut).into_iter().flatten() {
                for field in ["time_ms", "stage_ms", "time"] {
                    row.as_object_mut().expect("an object").remove(field);
                }
            }
        }
    }
    object
}

#[test]
fn the_papers_tables_are_repeated() {
    let place = Workplace::new();
    let (status, object) = place.json(QUICK);
    assert_eq!(status, 0, "{object}");
    assert_eq!(object["faults"], serde_json::json!([]));
    let names: Vec<&str> = object["tables"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|table| table["name"].as_str().expect("a name"))
        .collect();
    let expected = ["table_1", "figure_5", "table_2", "steps_roadways", "steps_mine"];
    assert_eq!(names, expected);
    for (index, rows, printed, reductions) in [(0, 15, 6, 6), (1, 9, 0, 0), (2, 25, 10, 6)] {
        let table = &object["tables"][index];
        assert_fields(
            table,
            "name text, title text, findings list, rows[].task text, rows[].variant text, rows[].label text, \
             rows[].length_m real, rows[].turns whole, rows[].turns_raw whole, rows[].turns_pruned null, \
             rows[].turns_smoothed null, rows[].min_clearance_m real, rows[].time_ms.p50 real, rows[].time_ms.p95 real, \
             rows[].stage_ms.search real, rows[].stage_ms.prune null, rows[].expanded whole, rows[].raw_length_m real, \
             rows[].over_shortest real, rows[].exact bool",
        );
        let count = |list: &str| table[list].as_array().expect("a list").len();
        assert_eq!(
            (count("rows"), count("paper"), count("reductions")),
            (rows, printed, reductions)
        );
    }
    assert_fields(
        &object["tables"][0],
        "paper[].task text, paper[].variant text, paper[].length_m real, paper[].time_ms real, paper[].turns null, \
         reductions[].variant text, reductions[].against text, reductions[].time.of_sums real, \
         reductions[].length.mean_of_rows real, reductions[].turns.of_sums real, \
         reductions[].turns_smoothed.of_sums real, paper_reductions[].time.of_sums real",
    );
    let steps = object["tables"][4]["rows"].as_array().expect("a list");
    assert_eq!(steps.len(), 13);
    assert_fields(
        &object["tables"][4],
        "rows[].search text, rows[].label text, rows[].stage text, rows[].time_ms real, rows[].length_m real, \
         rows[].turns whole, rows[].expanded whole, rows[].min_clearance_m real, rows[].over_shortest real, \
         rows[].worst_over_shortest real, breakdowns[].chain text, breakdowns[].against text, breakdowns[].measure text, \
         breakdowns[].before real, breakdowns[].after real, breakdowns[].total real, breakdowns[].search real, \
         breakdowns[].pruning real, breakdowns[].spline real, findings list",
    );
    let again = place.json(QUICK).1;
    assert_eq!(without_times(again), without_times(object));
}

#[test]
fn the_page_holds_all_it_needs() {
    let place = Workplace::new();
    let run = place.run(&format!("{QUICK} --report out/deep"));
    assert_eq!(run.status, 0, "{run:?}");
    assert_eq!(run.errors, ["report: out/deep/paper.html"]);
    assert!(run.stdout.starts_with("Table 1"), "{run:?}");
    assert!(run.stdout.contains("paper: improved"), "{run:?}");
    let page = fs::read_to_string(place.path("out/deep/paper.html")).expect("the page is there");
    assert!(page.ends_with("</html>"));
    // Three scenes and two paths of the mine with three maps each, the whole mine, and four charts, two of fig. 5.
    assert_eq!(page.matches("role=\"img\"").count(), 5 * 3 + 1 + 4);
    // What the first table shows, the paper's rows among ours, and the same with all digits.
    let read = |name: &str| fs::read_to_string(place.path(name)).expect("next to the page");
    let table = read("out/deep/table_1.csv");
    assert!(table.starts_with("scene or path,variant,\"length, m\""), "{table}");
    assert_eq!(table.lines().count(), 1 + 15 + 6, "{table}");
    assert!(!table.contains('\u{2013}'), "{table}");
    // Its charts of their own, with nothing from elsewhere.
    for (name, charts) in [("figure_5", 2), ("steps_roadways", 1), ("steps_mine", 1)] {
        let file = format!("{name}.svg");
        assert!(page.contains(&format!("href=\"{file}\"")), "{file}");
        let picture = read(&format!("out/deep/{file}"));
        let document = Document::parse(&picture).expect("sound markup");
        let headline = |node: &Node| node.attribute("class") == Some("headline");
        assert_eq!(document.descendants().filter(headline).count(), charts, "{file}");
        assert!(picture.contains(".stage-0 { fill"), "{file}");
        assert!(!picture.contains("NaN") && !picture.contains("url("), "{file}");
    }
    // Its maps too, without anything that only a browser knows: the number of path lines on the number of maps.
    for (name, maps, paths) in [
        ("figure_9", 3, 3),
        ("figure_10", 3, 3),
        ("figure_11", 3, 3),
        ("mine", 1, 10),
        ("figure_16_1", 3, 3),
        ("figure_16_2", 3, 3),
    ] {
        let file = format!("{name}.svg");
        assert!(page.contains(&format!("href=\"{file}\"")), "{file}");
        let picture = read(&format!("out/deep/{file}"));
        let document = Document::parse(&picture).expect("sound markup");
        let inner =
            |node: &Node| node.tag_name().name() == "svg" && node.parent_element().is_some();
        assert_eq!(document.descendants().filter(inner).count(), maps, "{file}");
        let is_path = |node: &Node| {
            let class = node.attribute("class").unwrap_or_default();
            node.tag_name().name() == "polyline" && class.ends_with("-path")
        };
        assert_eq!(document.descendants().filter(is_path).count(), paths, "{file}");
        for outside in ["var(", "url(", "NaN", "inf\""] {
            assert!(!picture.contains(outside), "{file}: {outside}");
        }
    }
    let rows: Value = serde_json::from_str(&read("out/deep/table_1.json")).expect("JSON");
    assert_eq!(rows["name"], "table_1");
    let own = page.replace("http://www.w3.org/2000/svg", "");
    for outside in ["http:", "https:", "<script", "<link", "url(", "NaN", ">inf<"] {
        assert!(!own.contains(outside), "{outside}");
    }
}

#[test]
fn the_scenes_are_driven() {
    let place = Workplace::new();
    let run =
        place.run("bench paper --mine mine.yaml --repetitions 1 --runs 1 --report out --json");
    let object: Value = serde_json::from_str(&run.stdout).expect("standard output is JSON");
    let tables = object["tables"].as_array().expect("a list");
    let drives = &tables[5..];
    let names: Vec<&Value> = drives.iter().map(|table| &table["name"]).collect();
    assert_eq!(names, ["table_3", "table_4", "table_4_non_yielding"]);
    let traffic: Vec<&Value> = drives.iter().map(|table| &table["traffic"]).collect();
    assert_eq!(traffic, ["none", "yielding", "non_yielding"]);
    for table in drives {
        assert_fields(
            table,
            "title text, rows[].kind text, rows[].world text, rows[].seed whole, rows[].outcome text, \
             rows[].final_dx_m real, rows[].final_dy_m real, rows[].final_yaw_error_rad real, rows[].time_s real, \
             rows[].travelled_m real, rows[].path_m real, rows[].min_clearance_m real, rows[].plans whole, \
             rows[].waited_share real, rows[].longest_wait_s real, rows[].final_speed_m_s real, rows[].fault null, \
             rows[].trace_digest text, summaries[].scene text, summaries[].runs whole, summaries[].reached whole, \
             summaries[].contacts whole, summaries[].near_people whole, summaries[].time_s real, \
             summaries[].waited_share real, paper.rows list, paper.of_rows.mean.dx_m real, paper.of_text.max.dyaw_rad real, \
             acceptance.no_contact bool, acceptance.all_reached bool, acceptance.means_within_limits bool, findings list",
        );
        let count = |list: &Value| list.as_array().expect("a list").len();
        assert_eq!([&table["rows"], &table["summaries"]].map(count), [3, 4]);
    }
    assert_fields(&drives[0], "rows[].nearest_moving_m null");
    assert_fields(&drives[1], "rows[].nearest_moving_m real");
    for table in &drives[..2] {
        assert_eq!(table["acceptance"]["no_contact"], true, "{table}");
        assert_eq!(table["acceptance"]["all_reached"], true, "{table}");
    }
    let faults = object["faults"].as_array().expect("a list");
    assert_eq!(run.status, i32::from(!faults.is_empty()));
    let page = fs::read_to_string(place.path("out/paper.html")).expect("the page is there");
    // Besides those of the paths, three maps and two charts for each kind of traffic.
    assert_eq!(page.matches("role=\"img\"").count(), 5 * 3 + 1 + 4 + 3 * (3 + 2));
    for name in ["table_3", "table_4", "table_4_non_yielding"] {
        assert!(page.contains(&format!("<section id=\"{name}\"")), "{name}");
    }
    for name in ["table_3", "table_4", "table_4_non_yielding"] {
        let picture = fs::read_to_string(place.path(&format!("out/{name}.svg"))).expect("charts");
        let document = Document::parse(&picture).expect("sound markup");
        // A mark of each drive that reached its goal and of each drive of the paper, in both charts.
        let circles = |class: &str| {
            let group = |node: &Node| {
                node.tag_name().name() == "g" && node.attribute("class") == Some(class)
            };
            let groups = document.descendants().filter(group);
            groups.map(|group| group.children().count()).sum::<usize>()
        };
        let table = tables.iter().find(|table| table["name"] == name).expect("a table");
        let arrived = table["rows"].as_array().expect("a list").iter();
        let arrived = arrived.filter(|row| row["outcome"] == "reached").count();
        let drawn = [circles("deviation measured"), circles("deviation published")];
        assert_eq!(drawn, [2 * arrived, 20], "{name}");
    }
    for words in ["Fig. 12", "Fig. 13", "text of the paper", "every drive reached its goal"] {
        assert!(page.contains(words), "{words}");
    }
    assert!(!page.contains("NaN") && !page.contains(">inf<"));
}

#[test]
fn mines_that_are_none_are_refused() {
    let place = Workplace::new();
    place.write("solid.txt", "####\n####\n####\n");
    for (arguments, words) in [
        ("--mine gone.yaml", "gone.yaml"),
        ("--mine solid.txt", "solid.txt: the map has no 10 connected places"),
        ("--repetitions 0", "whole number, 1 to 100000"),
        ("--runs 1001", "whole number, 0 to 1000"),
        ("--mine mine.yaml --report mine.yaml", "--report mine.yaml"),
    ] {
        let refusal = place.refusal(&format!("bench paper {arguments}"));
        assert!(refusal.contains(words), "{arguments}: {refusal}");
    }
}
