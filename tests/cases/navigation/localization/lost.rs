//! A robot that does not know where it is says so, stops, and goes on only when it is found.

use inbye::experiment::{LocalizationCase, LocalizationRow};
use inbye::sim::roadway;

use super::tours::plan;

fn drive(case: LocalizationCase, seed: u64) -> LocalizationRow {
    let drive = plan(roadway()).drive(case, seed);
    drive.expect("a way to the goal")
}

/// It says so within a second, stands within a metre and a half, and in the end gives up with the reason.
fn assert_lost(row: &LocalizationRow, why: &str) {
    assert!(!row.reached && !row.collided, "{row:#?}");
    assert!(row.lost_after_s.is_some_and(|s| s <= 1.0), "{row:#?}");
    assert!(row.driven_on_m.is_some_and(|m| m <= 1.5), "{row:#?}");
    let fault = row.fault.as_deref().unwrap_or_default();
    assert!(
        fault.starts_with("INVALID_OBSERVATION: the robot is lost: ") && fault.contains(why),
        "{fault}"
    );
    assert_eq!(row.found_after_s, None, "{row:#?}");
}

#[test]
fn carried_to_any_other_place_it_is_lost_and_not_found_where_it_is_not() {
    for seed in 0..6 {
        assert_lost(&drive(LocalizationCase::Elsewhere, seed), "lidar sees");
    }
}

#[test]
fn blinded_it_is_lost() {
    let why = "the lidar measures nothing where the map has walls";
    assert_lost(&drive(LocalizationCase::Blinded, 1), why);
}

#[test]
fn with_the_map_of_another_mine_it_is_lost() {
    assert_lost(&drive(LocalizationCase::OtherMap, 1), "lidar sees");
}

#[test]
fn carried_a_little_it_is_found_and_goes_on_to_its_goal() {
    for seed in 0..2 {
        let row = drive(LocalizationCase::Carried, seed);
        assert!(row.lost_after_s.is_some_and(|s| s <= 1.0), "{row:#?}");
        assert!(row.found_after_s.is_some(), "{row:#?}");
        assert!(row.reached && !row.collided, "{row:#?}");
        // Nobody moved it in its odometry: what is right is the map.
        assert!(
            row.worst_m <= 0.05 && row.odometry_worst_m > 1.0,
            "{row:#?}"
        );
    }
}

#[test]
fn blinded_for_a_moment_it_stops_and_goes_on() {
    let row = drive(LocalizationCase::BlindedForAMoment, 1);
    assert!(row.driven_on_m.is_some_and(|m| m <= 1.5), "{row:#?}");
    assert!(row.found_after_s.is_some_and(|s| s >= 2.0), "{row:#?}");
    assert!(row.reached && row.worst_m <= 0.05, "{row:#?}");
}

/// Where nothing tells how far along a roadway it is, it says that it is uncertain while it may be off, and stops before it is off
/// by much.
#[test]
fn in_a_smooth_roadway_it_does_not_claim_what_it_cannot_know() {
    let row = drive(LocalizationCase::Smooth, 1);
    assert!(row.uncertain_ticks > 100 && row.lost_ticks > 0, "{row:#?}");
    assert!(row.worst_tracking_m <= 0.05, "{row:#?}");
    assert!(row.worst_m <= 1.0 && row.worst_rad <= 0.02, "{row:#?}");
    let fault = row.fault.unwrap_or_default();
    assert!(fault.contains("walls have told too little"), "{fault}");
}
