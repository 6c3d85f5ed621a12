//! The metadata of a recording.

use std::io::Cursor;

use std::sync::Arc;

use inbye::geometry::{Point, Pose};
use inbye::map::{GridFrame, OccupancyGrid};
use inbye::navigator::{Goal, Waypoints};
use inbye::recording::{
    BackpressurePolicy, DriveMetadata, FORMAT, Reader, Recorder, RecordingError,
};
use inbye::runtime::Config;

use super::drives::Memory;
use crate::support::mcap_copy::altered;

pub const TESTS: &[super::Test] = &[
    ("metadata_keeps_every_bit", metadata_keeps_every_bit),
    ("recording_of_other_format_is_rejected", recording_of_other_format_is_rejected),
    ("map_of_other_size_is_rejected", map_of_other_size_is_rejected),
];

/// Metadata with numbers that need all their digits.
fn metadata() -> DriveMetadata {
    let third = 1.0 / 3.0;
    let frame =
        GridFrame::new(3, 2, 0.1 + 0.2, Pose::new(-0.0, 1e-300, third)).expect("a valid frame");
    let mut config = Config::default();
    config.robot.track_width_m = third;
    config.local.sim_time_s = 2.9_f64.next_up();
    config.navigator.deadline_s = Some(0.1_f64.next_down());
    let goal = |yaw| Goal { position: Point::new(0.1_f64.next_up(), -1e22), yaw };
    DriveMetadata {
        zones: None,
        controller: None,
        config,
        waypoints: Waypoints {
            start: Point::new(third, 5e-324),
            goals: vec![goal(None), goal(Some(third.next_up()))],
        },
        map: Arc::new(OccupancyGrid::new(frame, vec![-1, 0, 1, 65, 99, 100])),
        engine: "CPU \"of\" some\tkind".to_owned(),
    }
}

/// A recording without ticks.
fn recording(metadata: &DriveMetadata) -> Vec<u8> {
    let file = Memory::default();
    let recorder = Recorder::new(file.clone(), metadata, BackpressurePolicy::Block);
    let report = recorder.expect("valid metadata").finish(String::new());
    assert_eq!(report.stopped, None);
    file.bytes()
}

/// The error of a recording whose attachment `drive.toml` has another text of the same length in one place.
fn error_after(from: &str, to: &str) -> RecordingError {
    let copy = altered(&recording(&metadata()), "drive.toml", 0, |attachment| {
        let text = String::from_utf8(attachment.to_vec()).expect("text");
        assert!(text.contains(from), "{text}");
        attachment.copy_from_slice(text.replacen(from, to, 1).as_bytes());
    });
    Reader::open(Cursor::new(&copy[..])).expect_err("it cannot be replayed")
}

fn metadata_keeps_every_bit() {
    let metadata = metadata();
    let file = recording(&metadata);
    let reader = Reader::open(Cursor::new(&file[..])).expect("a recording");
    assert_eq!(*reader.metadata(), metadata);
    // `==` does not distinguish -0 and 0.
    let bits = |metadata: &DriveMetadata| metadata.map.frame().origin.x.to_bits();
    assert_eq!(bits(reader.metadata()), bits(&metadata));
    let mut other = metadata.clone();
    other.waypoints.start.x = other.waypoints.start.x.next_up();
    assert_ne!(*reader.metadata(), other);
}

fn recording_of_other_format_is_rejected() {
    let next = FORMAT + 1;
    let error = error_after(&format!("format = {FORMAT}"), &format!("format = {next}"));
    assert!(error.to_string().contains(&format!("format {next}")), "{error}");
}

fn map_of_other_size_is_rejected() {
    let error = error_after("width = 3", "width = 4");
    assert!(error.to_string().contains("6 cells, but 4 columns and 2 rows"), "{error}");
}
