//! A robot that loses its pose reports it, stops, and continues only after relocalisation.

use inbye::experiment::{LocalizationCase, RunOutcome, RunRow};
use inbye::sim::roadway;

use super::tours;

fn drive(case: LocalizationCase, seed: u64) -> RunRow {
    tours::drive(roadway(), case, seed)
}

/// Asserts that the loss is reported within 1 s, the robot stops within 1.5 m, and the mission ends with the reason.
fn assert_lost(row: &RunRow, reason: &str) {
    assert_eq!(row.outcome, RunOutcome::Failed, "{row:#?}");
    assert!(row.lost_after_s.is_some_and(|s| s <= 1.0), "{row:#?}");
    assert!(row.driven_on_m.is_some_and(|m| m <= 1.5), "{row:#?}");
    let fault = row.reason.as_deref().unwrap_or_default();
    assert!(
        fault.starts_with("INVALID_OBSERVATION: the robot is lost: ") && fault.contains(reason),
        "{fault}"
    );
    assert_eq!(row.found_after_s, None, "{row:#?}");
}

/// The whole map is searched, and only a unique match counts: the robot never drives on a wrong pose.
#[test]
fn robot_carried_far_is_found_at_its_true_pose_or_stays_lost() {
    for seed in 0..6 {
        let row = drive(LocalizationCase::KidnappedFar, seed);
        assert!(row.lost_after_s.is_some_and(|s| s <= 1.0), "{row:#?}");
        assert!(row.driven_on_m.is_some_and(|m| m <= 1.5), "{row:#?}");
        assert!(row.pose_error_max_m.is_some_and(|error| error <= 0.05), "{row:#?}");
        assert!(row.reached() || row.found_after_s.is_none(), "{row:#?}");
    }
}

#[test]
fn occluded_lidar_loses_the_pose() {
    let reason = "the lidar has no returns where the map shows walls";
    assert_lost(&drive(LocalizationCase::Occluded, 1), reason);
}

#[test]
fn wrong_map_loses_the_pose() {
    assert_lost(&drive(LocalizationCase::OtherMap, 1), "the map");
}

#[test]
fn robot_moved_a_little_relocalises_and_reaches_its_goal() {
    for seed in 0..2 {
        let row = drive(LocalizationCase::Kidnapped, seed);
        assert!(row.lost_after_s.is_some_and(|s| s <= 1.0), "{row:#?}");
        assert!(row.found_after_s.is_some(), "{row:#?}");
        assert!(row.reached(), "{row:#?}");
        // The odometry does not include the move, so only the map corrects it.
        assert!(row.pose_error_max_m.is_some_and(|error| error <= 0.05), "{row:#?}");
        assert!(row.odometry_error_max_m > Some(1.0), "{row:#?}");
    }
}

#[test]
fn briefly_occluded_lidar_stops_the_robot_until_it_relocalises() {
    let row = drive(LocalizationCase::BrieflyOccluded, 1);
    assert!(row.driven_on_m.is_some_and(|m| m <= 1.5), "{row:#?}");
    assert!(row.found_after_s.is_some_and(|s| s >= 2.0), "{row:#?}");
    assert!(row.reached() && row.pose_error_max_m.is_some_and(|error| error <= 0.05), "{row:#?}");
}

/// Without features along a roadway, the localiser reports an uncertain pose, and the robot stops before the error is
/// large.
#[test]
fn smooth_roadway_makes_the_pose_uncertain() {
    let row = drive(LocalizationCase::Smooth, 1);
    assert!(row.uncertain_ticks > Some(100) && row.lost_ticks > Some(0), "{row:#?}");
    assert!(row.tracking_error_max_m.is_some_and(|error| error <= 0.05), "{row:#?}");
    assert!(row.pose_error_max_m.is_some_and(|error| error <= 1.0), "{row:#?}");
    assert!(row.pose_error_max_rad.is_some_and(|error| error <= 0.02), "{row:#?}");
    let fault = row.reason.unwrap_or_default();
    assert!(fault.contains("have not constrained the pose"), "{fault}");
}
