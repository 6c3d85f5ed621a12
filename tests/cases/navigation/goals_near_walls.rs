//! Goals so near to a wall that the robot cannot turn there.

use std::f64::consts::PI;

use inbye::geometry::{Point, Pose};
use inbye::map::{Cell, GridFrame, ObstacleGrid};
use inbye::navigator::Goal;
use inbye::robot::{Footprint, Polygon};
use inbye::runtime::Config;

use super::narrow_passages::{drive_to, drive_with, planner, room};

/// A hall of 8 by 8 m with walls of 0.2 m.
fn hall() -> ObstacleGrid {
    let frame = GridFrame::new(160, 160, 0.05, Pose::default()).expect("a size");
    let is_wall = |at: i32| !(4..156).contains(&at);
    ObstacleGrid::from_fn(frame, |cell: Cell| is_wall(cell.column) || is_wall(cell.row))
}

/// The default robot fits lengthwise at 0.48 m from a wall, wherever in its cell the goal is.
#[test]
fn path_to_a_place_near_a_wall_does_not_depend_on_millimetres_or_on_the_start() {
    let (ground, mut planner) = (hall(), planner(|_| {}));
    for start_y in [3.0, 4.0, 5.0] {
        for (x, y) in [(7.275, 4.01), (7.275, 4.02), (7.28, 4.0), (7.28, 4.025), (7.32, 4.0)] {
            let (start, goal) = (Point::new(2.0, start_y), Point::new(x, y));
            let plan = planner.plan(&ground, start, goal, &mut || 0.0);
            assert!(plan.is_ok(), "{start:?} {goal:?}: {plan:?}");
        }
    }
}

#[test]
fn robot_turns_to_the_yaw_of_its_goal_before_the_wall_leaves_no_room() {
    let config = Config::default();
    for yaw in [0.5, -1.0, -2.0, 3.0] {
        let goal = Goal { position: Point::new(7.32, 4.0), yaw: Some(yaw) };
        let result = drive_to(&config, &hall(), Pose::new(2.0, 4.0, 0.0), &[goal]);
        let (x_m, y_m) = result.final_error_m;
        let off_m = (x_m * x_m + y_m * y_m).sqrt();
        let off_rad = result.final_yaw_error.expect("the goal has a yaw");
        assert!(result.reached && result.time_s < 30.0, "{yaw}: {} s", result.time_s);
        assert!(off_m <= config.navigator.xy_goal_tolerance, "{yaw}: {off_m} m");
        assert!(off_rad.abs() <= config.navigator.yaw_goal_tolerance, "{yaw}: {off_rad}");
    }
}

/// The distance of a robot from its goal at the end of its drive, metres, along x and along y.
fn final_error_m(start: Pose, goal: Goal) -> (f64, f64) {
    let result = drive_to(&Config::default(), &hall(), start, &[goal]);
    assert!(result.reached && result.time_s < 35.0, "{goal:?}: {} s", result.time_s);
    let off_rad = result.final_yaw_error.expect("the goal has a yaw");
    assert!(off_rad.abs() < 0.05, "{goal:?}: {off_rad}");
    (result.final_error_m.0.abs(), result.final_error_m.1.abs())
}

/// The robot comes at an angle. It fits 0.45 m from the wall with these yaws, and with none between them.
#[test]
fn robot_turns_in_front_of_a_goal_at_a_wall_and_drives_straight_to_it() {
    for yaw in [0.0, PI] {
        for start in [Pose::new(2.0, 1.0, 0.0), Pose::new(5.0, 7.0, -1.0)] {
            let goal = Goal { position: Point::new(7.35, 4.0), yaw: Some(yaw) };
            let (x_m, y_m) = final_error_m(start, goal);
            assert!(x_m < 0.03 && y_m < 0.03, "{yaw} {start:?}: {x_m}, {y_m} m");
        }
    }
}

/// Nose to the wall, 0.05 m are left in front of the robot at its goal.
#[test]
fn goal_without_a_margin_to_the_wall_moves_straight_away_from_it() {
    let goal = Goal { position: Point::new(7.4, 4.0), yaw: Some(0.0) };
    let (x_m, y_m) = final_error_m(Pose::new(2.0, 2.0, 0.5), goal);
    assert!((0.02..0.1).contains(&x_m) && y_m < 0.03, "{x_m}, {y_m} m");
}

/// The discs that cover a triangle reach far beyond its tip. Where the circle around it has room, the path is clear: here in front of the
/// wall behind the goal.
#[test]
fn triangular_robot_keeps_its_path_through_a_door() {
    let mut config = Config::default();
    let corners = [(0.5, 0.0), (-0.3, -0.35), (-0.3, 0.35)].map(|(x, y)| Point::new(x, y));
    config.robot.footprint =
        Footprint::covering(Polygon::new(corners.to_vec()).expect("a polygon"));
    let start = Pose::new(2.0, 4.5, 0.0);
    let result = drive_with(&config, &room(1.0, 0.0), start, Point::new(11.25, 3.0));
    assert!(result.reached, "{:?}", result.fault);
    assert_eq!(result.plans.len(), 1);
}
