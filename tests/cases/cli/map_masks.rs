//! Zones by masks, worlds that differ from the map, and the map with what the scans contradicted.

use std::io::Cursor;

use inbye::geometry::Point;
use inbye::map::OccupancyGrid;
use inbye::recording::Reader;
use serde_json::{Value, json};

use super::program::Workplace;
use crate::support::mcap_copy::altered;

/// Size of the hall, cells of 0.05 m: 12 by 8 m.
const WIDTH: usize = 240;
const HEIGHT: usize = 160;

/// Writes a map of the hall: grey values by column and row, counted from the lower left.
fn write_map(place: &Workplace, name: &str, more: &str, grey: impl Fn(usize, usize) -> u8) {
    let mut image = format!("P5\n{WIDTH} {HEIGHT}\n255\n").into_bytes();
    for row in (0..HEIGHT).rev() {
        image.extend((0..WIDTH).map(|column| grey(column, row)));
    }
    place.write(&format!("{name}.pgm"), image);
    let yaml =
        format!("image: {name}.pgm\nresolution: 0.05\norigin: [0.0, 0.0, 0.0]\nnegate: 0\n{more}");
    place.write(&format!("{name}.yaml"), yaml);
}

const TRINARY: &str = "occupied_thresh: 0.65\nfree_thresh: 0.196\n";
const SCALE: &str = "occupied_thresh: 1.0\nfree_thresh: 0.0\nmode: scale\n";

fn is_wall(column: usize, row: usize) -> bool {
    !(10..WIDTH - 10).contains(&column) || !(10..HEIGHT - 10).contains(&row)
}

/// A hall with a closed zone between start and goal, and a zone of 30 percent speed before the goal.
fn hall() -> Workplace {
    let place = Workplace::new();
    let black_where = |is_black: bool| if is_black { 0 } else { 254 };
    write_map(&place, "hall", TRINARY, |column, row| black_where(is_wall(column, row)));
    write_map(&place, "keepout", TRINARY, |column, row| {
        black_where((80..130).contains(&column) && row < 105)
    });
    let slow = |column: usize, row: usize| (160..200).contains(&column) && (30..100).contains(&row);
    let grey = move |column, row| if slow(column, row) { 77 } else { 255 };
    write_map(&place, "slow", SCALE, grey);
    write_map(&place, "black", TRINARY, grey);
    place
}

/// Nav2 scales such a mask in the same way: a warning, no error.
#[test]
fn speed_mask_with_the_thresholds_of_a_map_gets_a_warning() {
    let place = hall();
    let grey = |column, _| if (160..200).contains(&column) { 128 } else { 230 };
    write_map(&place, "clipped", &format!("{TRINARY}mode: scale\n"), grey);
    write_map(&place, "exact", SCALE, grey);
    let warnings = |arguments: &str| {
        let run = place.run(&format!("plan {arguments}"));
        assert_eq!(run.status, 0, "{run:?}");
        run.errors
    };
    let found = warnings(&format!("{ENDS} --speed-zones clipped.yaml"));
    assert_eq!(found.len(), 1, "{found:?}");
    for part in [
        "warning: --speed-zones clipped.yaml: ",
        "`free_thresh: 0.196` and `occupied_thresh: 0.65`",
        "set `free_thresh: 0.0` and `occupied_thresh: 1.0`",
    ] {
        assert!(found[0].contains(part), "{found:?}");
    }
    assert_eq!(warnings(&format!("{ENDS} --speed-zones exact.yaml")), [""; 0]);
    // A map has such thresholds as a rule.
    let map = "--map clipped.yaml --unknown free --start 2,2 --goal 4,2";
    assert_eq!(warnings(map), [""; 0]);
}

const ENDS: &str = "--map hall.yaml --start 2,2 --goal 10,2";

fn number(object: &Value, name: &str) -> f64 {
    object[name].as_f64().unwrap_or(f64::NAN)
}

#[test]
fn plan_leads_around_a_closed_zone_and_the_picture_shows_it() {
    let place = hall();
    let (_, free) = place.json(&format!("plan {ENDS}"));
    let (status, around) =
        place.json(&format!("plan {ENDS} --keepout keepout.yaml --svg plan.svg"));
    assert_eq!(status, 0);
    assert!(number(&free, "length_m") < 8.2 && number(&around, "length_m") > 11.0, "{around}");
    assert!(number(&around, "min_clearance_m") > 0.42, "{around}");
    let picture = std::fs::read_to_string(place.path("plan.svg")).unwrap();
    assert!(picture.contains("class=\"closed-zone\"") && picture.contains("closed zone</text>"));
    assert!(!picture.contains("class=\"slow-zone\""));
}

/// The robot would have room between the walls: the message must not look for an obstacle there.
#[test]
fn path_that_closed_zones_block_is_reported_with_them() {
    let place = hall();
    write_map(
        &place,
        "all",
        TRINARY,
        |column, _| if (80..130).contains(&column) { 0 } else { 254 },
    );
    for command in ["plan", "drive --engine cpu"] {
        let run = place.run(&format!("{command} {ENDS} --keepout all.yaml"));
        assert_eq!(run.status, 1, "{run:?}");
        let note = "; the closed zones of --keepout count as obstacles";
        assert!(run.stdout.trim_end().ends_with(note), "{run:?}");
        let refusal = place.refusal(&format!(
            "{command} --map hall.yaml --start 2,2 --goal 3.9,2 --keepout all.yaml"
        ));
        assert!(refusal.contains("GOAL_OCCUPIED") && refusal.contains(note), "{refusal}");
    }
}

#[test]
fn drive_keeps_zones_and_its_recording_has_them() {
    let place = hall();
    let drive = format!(
        "drive {ENDS} --engine cpu --keepout keepout.yaml --speed-zones slow.yaml --record run.mcap"
    );
    let (status, object) = place.json(&drive);
    assert_eq!((status, &object["reached"]), (0, &json!(true)));
    let zones = &object["zones"];
    assert!(zones["intrusions"] == 0 && number(zones, "min_gap_m") > 0.05, "{zones}");
    // Two metres at 0.3 m/s.
    assert!(number(zones, "limited_ticks") > 50.0 && number(zones, "max_excess") < 0.05, "{zones}");
    let (status, replay) = place.json("replay run.mcap --engine cpu");
    assert_eq!((status, &replay["agree"]), (0, &json!(true)), "{replay}");
    let (_, free) = place.json(&format!("drive {ENDS} --engine cpu"));
    assert!(free["zones"].is_null() && number(&free, "time_s") < number(&object, "time_s"));
}

#[test]
fn unusable_masks_are_refused() {
    let place = hall();
    write_map(&place, "far", TRINARY, |_, _| 0);
    let far = std::fs::read_to_string(place.path("far.yaml")).unwrap();
    place.write("far.yaml", far.replace("[0.0, 0.0, 0.0]", "[50.0, 0.0, 0.0]"));
    let hall = "hall.yaml --start 2,2";
    for (arguments, words) in [
        (format!("plan {ENDS} --keepout far.yaml"), "far.yaml: the mask does not lie on the map"),
        (format!("plan {ENDS} --keepout slow.yaml"), "no cell of the map is closed"),
        (format!("drive {ENDS} --speed-zones black.yaml"), "occupied_thresh: 1.0"),
        (format!("drive {ENDS} --speed-zones hall.yaml"), "limit of zero"),
        (
            format!("plan --map {hall} --goal 5,2 --keepout keepout.yaml"),
            "--goal 5,2: lies in a closed zone",
        ),
        (format!("drive {ENDS} --keepout missing.yaml"), "missing.yaml"),
        (format!("drive {ENDS} --update-map new.yaml"), "--update-map needs the pose from scans"),
        (
            format!("drive {ENDS} --set pose_source=\"scans\" --update-map new.png"),
            "must end in .yaml",
        ),
        (format!("drive {ENDS} --truth mine.yaml"), "must have the size"),
    ] {
        let refusal = place.refusal(&arguments);
        assert!(refusal.contains(words), "{arguments}: {refusal}");
    }
}

/// A colon within quotation marks does not begin the hint.
#[test]
fn hint_of_json_error_keeps_quoted_settings_whole() {
    let run = hall().run(&format!("drive {ENDS} --speed-zones black.yaml --json"));
    let refused: Value = serde_json::from_str(&run.stdout).unwrap();
    let hint = refused["error"]["hint"].as_str().unwrap();
    assert!(hint.starts_with("close the zone"), "{hint}");
    assert!(hint.ends_with("set `mode: scale` and `occupied_thresh: 1.0` in the mask"), "{hint}");
}

/// A box stands in the world and not on the map; a pillar of the map is gone.
#[test]
fn updated_map_has_what_the_scans_contradicted() {
    let place = Workplace::new();
    let pillar =
        |column: usize, row: usize| (160..168).contains(&column) && (30..60).contains(&row);
    let added = |column: usize, row: usize| (100..112).contains(&column) && (90..98).contains(&row);
    let grey = |is_black: bool| if is_black { 0 } else { 254 };
    write_map(&place, "map", TRINARY, |x, y| grey(is_wall(x, y) || pillar(x, y)));
    write_map(&place, "world", TRINARY, |x, y| grey(is_wall(x, y) || added(x, y)));
    let drive = "drive --map map.yaml --truth world.yaml --set pose_source=\"scans\" --engine cpu --start 2,2 --via 10,2 \
                 --via 10,6 --via 2,6 --via 10,3 --via 3,6 --via 10,5 --goal 2,3 --update-map new.yaml";
    let (status, object) = place.json(drive);
    assert_eq!((status, &object["reached"]), (0, &json!(true)), "{object}");
    let area = |name: &str| {
        // The sides of the box that the lidar sees need not touch.
        let areas = object["map_changes"][name].as_array().unwrap();
        assert!((1..=4).contains(&areas.len()), "{object}");
        (number(&areas[0], "x"), number(&areas[0], "y"), number(&areas[0], "cells"))
    };
    let (x, y, cells) = area("appeared");
    assert!((x - 5.3).abs() < 0.15 && (y - 4.7).abs() < 0.15 && cells >= 20.0, "{object}");
    let (x, y, cells) = area("vanished");
    assert!((x - 8.2).abs() < 0.1 && (y - 2.25).abs() < 0.15 && cells >= 200.0, "{object}");
    // Planned with: the new map has a path where the pillar stood, and none through the box.
    let (_, around) = place.json("plan --map new.yaml --start 4,4.7 --goal 7,4.7");
    assert!(number(&around, "length_m") > 3.1, "{around}");
    let (_, through) = place.json("plan --map new.yaml --start 7,2.25 --goal 10,2.25");
    assert!(number(&through, "length_m") < 3.05, "{through}");
    let run = place.run(&format!("{drive} --report out --record run.mcap"));
    assert_eq!(run.status, 0, "{run:?}");
    let page = std::fs::read_to_string(place.path("out/index.html")).unwrap();
    assert!(page.contains("class=\"appeared\"") && page.contains("class=\"vanished\""));
    let (_, known) = place.json("drive --map map.yaml --engine cpu --start 2,2 --goal 4,2");
    assert!(known["map_changes"].is_null());
    let kept = "--set navigator.features.map_changes=false --record kept.mcap";
    let (_, kept) = place.json(&format!("{drive} {kept}"));
    assert_ne!(kept["map_changes"]["vanished"], json!([]), "{kept}");
    let kept = std::fs::read(place.path("kept.mcap")).unwrap();
    let mut kept = Reader::open(Cursor::new(&kept[..])).unwrap();
    while kept.next_tick().unwrap().is_some() {
        assert!(kept.take_updated_map().is_none());
    }
    // The navigator has used it in the drive already. A replay does likewise, and differs with another map.
    let (status, replay) = place.json("replay run.mcap --engine cpu");
    assert_eq!((status, &replay["complete"]), (0, &json!(true)), "{replay}");
    let recording = std::fs::read(place.path("run.mcap")).unwrap();
    let mut reader = Reader::open(Cursor::new(&recording[..])).unwrap();
    let mut updated = Vec::new();
    while let Some(tick) = reader.next_tick().unwrap() {
        updated.extend(reader.take_updated_map().map(|map| (tick.tick, map)));
    }
    let is_occupied = |map: &OccupancyGrid, x, y| {
        map.get(map.frame().cell_of(&Point::new(x, y)).unwrap()) == Some(&100)
    };
    let has_no_pillar = |map| is_occupied(map, 2.0, 0.1) && !is_occupied(map, 8.2, 2.25);
    assert!(updated.iter().any(|(_, map)| has_no_pillar(map)));
    let other = altered(&recording, "/updated_map", 0, |message| {
        let cells = message.len() - WIDTH * HEIGHT;
        message[cells..].fill(100);
    });
    place.write("other.mcap", other);
    let (status, replay) = place.json("replay other.mcap --engine cpu");
    assert_eq!(status, 1, "{replay}");
    let differs_at = number(&replay["first_difference"], "tick");
    assert_eq!(differs_at, updated[0].0 as f64, "{replay}");
}
