//! `inbye drive --record FILE.mcap` and `inbye replay`.

use std::fs;

use serde_json::{Value, json};

use super::program::{Workplace, assert_fields};
use crate::support::mcap_copy::{altered, chunk_ends};
use crate::support::room;

const DRIVE: &str = "drive --map room.txt --resolution 0.2 --start 1.5,2.5 --goal 10.5,2.5 --obstacles 1 --seed 4 \
    --time-limit 30 --engine cpu";

fn room() -> Workplace {
    let place = Workplace::new();
    place.write("room.txt", room::rows(60, 26, &[]).join("\n"));
    place
}

/// Records a drive as `run.mcap` and returns its JSON.
fn recorded(place: &Workplace) -> Value {
    let (status, object) = place.json(&format!("{DRIVE} --record run.mcap"));
    assert_eq!(status, 0, "{object}");
    object
}

#[test]
fn replay_reproduces_recorded_drive() {
    let place = room();
    let drive = recorded(&place);
    assert_fields(
        &drive,
        "recording.file text, recording.messages whole, recording.bytes whole, recording.stopped null",
    );
    let size = fs::metadata(place.path("run.mcap")).expect("it is there").len();
    assert_eq!(drive["recording"]["bytes"], json!(size));
    let bytes = fs::read(place.path("run.mcap")).expect("it is there");
    let date = b"inbye.start";
    assert!(!bytes.windows(date.len()).any(|part| part == date), "a simulation has no date");
    let (_, alone) = place.json(DRIVE);
    assert_eq!(alone["trace_digest"], drive["trace_digest"]);
    assert_eq!(alone["recording"], Value::Null);
    for engine in ["--engine cpu --threads 1", "--engine cpu --threads 2", ""] {
        let (status, replay) = place.json(&format!("replay run.mcap {engine}"));
        assert_eq!(status, 0, "{replay}");
        assert_fields(&replay, "engine text, recorded_engine text, first_difference null");
        assert_eq!(replay["ticks"], drive["ticks"]);
        assert_eq!(replay["recorded_engine"], drive["engine"]);
        assert_eq!((&replay["agree"], &replay["complete"]), (&json!(true), &json!(true)));
    }
    let run = place.run("replay run.mcap --engine cpu --report out --quiet");
    assert!(run.stdout.starts_with("the same bits in all "), "{run:?}");
    let page = fs::read_to_string(place.path("out/index.html")).expect("the page is written");
    let frames = format!("\"frames\":{}", drive["ticks"]);
    assert!(page.contains("class=\"player\"") && page.contains(&frames), "{frames}");
    assert!(page.contains("goal reached") && page.contains("replayed from its recording"));
}

#[test]
fn flipped_bit_is_reported_with_tick_and_field() {
    let place = room();
    recorded(&place);
    let file = fs::read(place.path("run.mcap")).expect("it is there");
    // The last bit of the commanded speed, after 360 ranges.
    let copy = altered(&file, "/inbye/tick", 11, |message| {
        message[164 + 8 * 360] ^= 1;
    });
    place.write("other.mcap", copy);
    let (status, replay) = place.json("replay other.mcap --engine cpu");
    assert_eq!(status, 1, "{replay}");
    assert_eq!(replay["agree"], json!(false));
    let difference = &replay["first_difference"];
    assert_fields(
        difference,
        "time_s real, recorded real, replayed real, recorded_hex text, replayed_hex text",
    );
    assert_eq!((&difference["tick"], &difference["field"]), (&json!(11), &json!("command_linear")));
    assert_ne!(difference["recorded_hex"], difference["replayed_hex"]);
    let run = place.run("replay other.mcap --engine cpu");
    assert_eq!(run.status, 1);
    assert!(
        run.stdout.starts_with("DIFFERS first at tick 11 of ") && run.stdout.contains("0x3f"),
        "{run:?}"
    );
}

#[test]
fn truncated_recording_is_replayed_to_its_end() {
    let place = room();
    let drive = recorded(&place);
    let file = fs::read(place.path("run.mcap")).expect("it is there");
    let ends = chunk_ends(&file);
    place.write("truncated.mcap", &file[..ends[2] + 1000]);
    let (status, replay) = place.json("replay truncated.mcap --engine cpu");
    assert_eq!(status, 0, "{replay}");
    assert_eq!((&replay["agree"], &replay["complete"]), (&json!(true), &json!(false)));
    assert!(
        replay["ticks"].as_u64() > Some(20) && replay["ticks"].as_u64() < drive["ticks"].as_u64()
    );
    let run = place.run("replay truncated.mcap --engine cpu --report page");
    assert!(run.stdout.contains("the recording is truncated: it ends with tick "), "{run:?}");
    let page = fs::read_to_string(place.path("page/index.html")).expect("the page");
    assert!(page.contains("the recording is truncated: it ends before the drive did"));
}

#[test]
fn extension_in_capitals_is_that_of_a_recording() {
    let place = room();
    let (status, object) = place.json(&format!("{DRIVE} --record RUN.MCAP"));
    assert_eq!(status, 0, "{object}");
    assert_eq!(place.json("replay RUN.MCAP --engine cpu").0, 0);
    let (status, map) = place.json("map RUN.MCAP --out ROOM.YAML");
    assert_eq!((status, &map["format"]), (0, &json!("ros2")), "{map}");
}

/// Other tools find the lidar by its frame.
#[test]
fn recording_of_a_lidar_off_the_origin_is_replayed_and_mapped() {
    let place = room();
    let lidar = "--set simulation.lidar.mount_x_m=0.3 --set simulation.lidar.mount_yaw_rad=2 --set simulation.lidar.sweep_s=0.1";
    let (status, drive) = place.json(&format!("{DRIVE} {lidar} --record run.mcap"));
    assert_eq!(status, 0, "{drive}");
    let (status, replay) = place.json("replay run.mcap --engine cpu");
    assert_eq!((status, &replay["agree"]), (0, &json!(true)), "{replay}");
    let (status, map) = place.json("map run.mcap --out ROOM.YAML");
    assert_eq!(status, 0, "{map}");
    let farthest_m = map["absolute"]["position_m"]["max"].as_f64();
    assert!(farthest_m.is_some_and(|farthest_m| farthest_m < 0.05), "{map}");
}

#[test]
fn unusable_recordings_are_rejected_with_one_line() {
    let place = room();
    recorded(&place);
    let file = fs::read(place.path("run.mcap")).expect("it is there");
    let ends = chunk_ends(&file);
    place.write("head.mcap", &file[..ends[0]]);
    place.write("empty.mcap", "");
    let mut damaged = file.clone();
    damaged[ends[2] - 5000] ^= 1;
    place.write("damaged.mcap", damaged);
    let newer = altered(&file, "drive.toml", 0, |text| {
        let format = text.windows(10).position(|bytes| bytes == b"format = 7");
        text[format.expect("the format is stated") + 9] = b'8';
    });
    place.write("newer.mcap", newer);
    for (name, words) in [
        ("gone.mcap", "name a recording"),
        ("room.txt", "no MCAP file"),
        ("empty.mcap", "no recording of"),
        ("head.mcap", "no tick"),
        ("damaged.mcap", "damaged after"),
        ("newer.mcap", "format 7"),
    ] {
        let line = place.refusal(&format!("replay {name} --engine cpu"));
        assert!(line.contains(name) && line.contains(words), "{name}: {line}");
    }
    let line = place.refusal("replay run.mcap --engine warp");
    assert!(line.contains("warp"), "{line}");
}

#[cfg(target_os = "linux")]
#[test]
fn full_disk_stops_recording_but_not_drive() {
    let place = room();
    let alone = place.json(DRIVE).1;
    for name in ["full.mcap", "full.jsonl"] {
        std::os::unix::fs::symlink("/dev/full", place.path(name)).expect("a new name");
        let run = place.run(&format!("{DRIVE} --record {name} --json"));
        let object: Value = serde_json::from_str(&run.stdout).expect("the drive has a result");
        assert_eq!((run.status, &object["reached"]), (1, &json!(true)), "{run:?}");
        assert_eq!(object["trace_digest"], alone["trace_digest"]);
        let recording = &object["recording"];
        assert_eq!(recording["file"], json!(name));
        let reason = recording["stopped"].as_str().expect("a reason");
        assert!(reason.contains("No space left on device"), "{reason}");
        assert_eq!(run.errors.len(), 1, "{run:?}");
        assert!(
            run.errors[0].starts_with("warning: the recording stopped: ")
                && run.errors[0].contains(name),
            "{run:?}"
        );
    }
}
