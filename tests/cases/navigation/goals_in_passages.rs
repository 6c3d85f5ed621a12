//! Goals with a yaw in passages in which the robot cannot turn on the spot.

use core::f64::consts::PI;

use inbye::geometry::{Point, Pose};
use inbye::map::{GridFrame, ObstacleGrid};
use inbye::navigator::Goal;
use inbye::runtime::{Config, MissionResult};

use super::narrow_passages::{add_border, dead_end, drive_to};

/// A goal in a passage along x, in its middle.
fn in_passage(x: f64, yaw: f64) -> Goal {
    Goal { position: Point::new(x, 3.0), yaw: Some(yaw) }
}

fn assert_at_yaw(result: &MissionResult, what: &str) {
    let error = result.final_yaw_error.map_or(f64::INFINITY, f64::abs);
    let MissionResult { reached, min_clearance_m, fault, .. } = result;
    let is_right = *reached && error < 0.05 && *min_clearance_m > 0.03;
    assert!(is_right, "{what}: {fault:?}, {error} rad, {min_clearance_m} m");
}

/// The largest distance that the robot drove tail first inside the passage, by its x, metres.
fn reversed_m(result: &MissionResult) -> f64 {
    let rows = result.trace.rows.iter().filter(|row| row.twist.linear < -0.05);
    let (low, high) = rows.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), row| {
        (low.min(row.pose.x), high.max(row.pose.x))
    });
    (high - low).max(0.0)
}

/// The robot fits in the passage only lengthwise, so its yaw there follows from how it drives in.
#[test]
fn robot_turns_where_it_has_room_before_it_drives_to_a_goal_where_it_has_none() {
    let (config, obstacles) = (Config::default(), dead_end(0.8));
    // From the room; from the passage, where it already has the yaw of the goal; and from there with the opposite yaw.
    for (start_x, start_yaw, goal_yaw, reverses_m, longest_m) in [
        (3.0, 0.0, 0.0, 0.0..0.3, 7.0),
        (3.0, 0.0, PI, 2.0..7.0, 7.0),
        (7.5, PI, PI, 1.0..2.0, 2.0),
        (7.5, 0.0, 0.0, 0.0..0.3, 2.0),
        (7.5, 0.0, PI, 2.0..7.0, 9.0),
        (7.5, PI, 0.0, 0.0..0.3, 9.0),
    ] {
        let start = Pose::new(start_x, 3.0, start_yaw);
        let result = drive_to(&config, &obstacles, start, &[in_passage(9.0, goal_yaw)]);
        let what = format!("from {start:?} to {goal_yaw}");
        assert_at_yaw(&result, &what);
        let reversed_m = reversed_m(&result);
        let is_short = result.travelled_m < longest_m;
        assert!(reverses_m.contains(&reversed_m) && is_short, "{what}: {reversed_m} m, {result:?}");
    }
}

/// The place where the robot turns is no stop of the mission.
#[test]
fn each_goal_of_a_mission_has_its_own_place_to_turn() {
    let goals = [in_passage(8.0, PI), in_passage(9.0, 0.0), in_passage(8.0, PI)];
    let result = drive_to(&Config::default(), &dead_end(0.8), Pose::new(3.0, 3.0, 0.0), &goals);
    assert_at_yaw(&result, "three goals");
    let errors: Vec<f64> = result.stop_errors.iter().filter_map(|stop| stop.yaw_rad).collect();
    assert!(errors.len() == 2 && errors.iter().all(|error| error.abs() < 0.05), "{errors:?}");
}

/// A passage between two rooms: the nearest place to turn is beyond the goal, from where the robot comes back nose first.
#[test]
fn robot_that_cannot_reverse_turns_beyond_its_goal() {
    let frame = GridFrame { width: 320, height: 120, resolution_m: 0.05, origin: Pose::default() };
    let is_free = |at: Point| !(6.0..10.0).contains(&at.x) || (at.y - 3.0).abs() < 0.4;
    let mut obstacles = ObstacleGrid::from_fn(frame, |cell| !is_free(frame.center_of(cell)));
    add_border(&mut obstacles);
    let mut config = Config::default();
    config.robot.limits = config.robot.limits.min_vel_x(0.0);
    let start = Pose::new(3.0, 3.0, 0.0);
    let result = drive_to(&config, &obstacles, start, &[in_passage(9.0, PI)]);
    assert_at_yaw(&result, "beyond");
    assert!(reversed_m(&result) == 0.0 && result.travelled_m > 7.0, "{}", result.travelled_m);
    // Here the nearest place is in front of the goal, which it would have to leave tail first.
    let result = drive_to(&config, &obstacles, start, &[in_passage(7.0, PI)]);
    let why = result.fault.map(|fault| fault.to_string()).unwrap_or_default();
    assert!(!result.reached && why.contains("no room to turn"), "{why}");
}
