//! `inbye bench localization`.

use serde_json::Value;

use super::program::{Workplace, assert_fields};
use crate::support::room;

#[test]
fn localization_drives_a_case_and_resumes_from_its_folder() {
    let place = Workplace::new();
    let bench = "bench localization --case briefly_occluded --seeds 1 --seed 1 --out cells";
    let (status, object) = place.json(&format!("{bench} --record rows.csv"));
    assert_eq!(status, 0, "{object}");
    assert_eq!(object["within"], true);
    assert_fields(
        &object,
        "rows[].kind text, rows[].world text, rows[].case text, rows[].seed whole, rows[].outcome text, rows[].slip real, \
         rows[].pose_error_max_m real, rows[].pose_error_max_rad real, rows[].tracking_error_max_m real, \
         rows[].pose_error_rms_m real, rows[].odometry_error_max_m real, rows[].pose_sigma_max_m real, \
         rows[].unobserved_share real, rows[].agreement_min_share real, rows[].uncertain_ticks whole, \
         rows[].lost_ticks whole, rows[].lost_reason text, rows[].lost_after_s real, rows[].driven_on_m real, \
         rows[].found_after_s real, rows[].trace_digest text, rows[].key text",
    );
    let row = &object["rows"][0];
    assert_eq!(
        (&row["world"], &row["outcome"]),
        (&"roadway briefly_occluded".into(), &"reached".into())
    );
    let record = std::fs::read_to_string(place.path("rows.csv")).expect("the record is there");
    assert_eq!(record.lines().count(), 2, "{record}");
    // The second run reads the result, also its times.
    assert_eq!(place.json(bench).1, object);
    // A merge also writes a page, whose path is a note.
    let merged = place.run("sweep merge cells --json");
    let merged: Value = serde_json::from_str(&merged.stdout).expect("standard output is JSON");
    assert_eq!(merged["missing"], Value::Array(Vec::new()));
    let refusal = place.refusal("bench localization --case none");
    assert!(refusal.contains("it is one of tour, people"), "{refusal}");
}

#[test]
fn localization_fails_when_a_drive_cannot_start() {
    let place = Workplace::new();
    place.write("room.txt", room::rows(30, 20, &[]).join("\n"));
    let bench =
        "bench localization --map room.txt --resolution 0.2 --start 1.5,2 --goal 4,2 --seeds 1";
    // A case that is named twice is driven once.
    let (status, object) = place.json(&format!("{bench} --case people --case people"));
    assert_eq!((status, &object["within"]), (1, &Value::Bool(false)), "{object}");
    let rows = object["rows"].as_array().expect("a list");
    assert_eq!(rows.len(), 1, "{object}");
    assert_eq!((&rows[0]["case"], &rows[0]["outcome"]), (&"people".into(), &"error".into()));
    assert!(rows[0]["reason"].is_string(), "{object}");
}
