//! Other ways, where the discs of the robot pass a narrow passage and its body does not.

use inbye::geometry::{Point, Pose};
use inbye::global::PlanError;
use inbye::map::{Cell, GridFrame, ObstacleGrid};
use inbye::navigator::{Goal, NavigatorSettings};
use inbye::runtime::Config;

use super::narrow_passages::{add_border, drive_among, least_gap_m, planner};

const START: Point = Point::new(2.0, 2.0);
const GOAL: Point = Point::new(10.0, 2.0);

/// Two rooms with a door of 0.8 m at y = 2, and a crate behind it. The robot drives into this door and cannot turn there, though a
/// disc as wide as the robot passes. A second door may be at y = 8.
fn rooms(has_second_door: bool) -> ObstacleGrid {
    let frame = GridFrame { width: 240, height: 200, resolution_m: 0.05, origin: Pose::default() };
    let is_blocked = |cell: Cell| {
        let Point { x, y } = frame.center_of(cell);
        let is_door = (y - 2.0).abs() < 0.4 || has_second_door && (y - 8.0).abs() < 0.4;
        let is_wall = (x - 6.0).abs() < 0.1 && !is_door;
        let is_crate = (6.85..7.3).contains(&x) && (1.0..3.0).contains(&y);
        is_wall || is_crate
    };
    let mut obstacles = ObstacleGrid::from_fn(frame, is_blocked);
    add_border(&mut obstacles);
    obstacles
}

#[test]
fn robot_takes_another_door_where_it_cannot_turn_behind_the_nearest_one() {
    let obstacles = rooms(true);
    let plan = planner(|_| {}).plan(&obstacles, START, GOAL, &mut || 0.0).expect("a second door");
    let points = plan.smoothed.points();
    assert!(points.iter().any(|point| point.y > 7.0), "{points:?}");
    assert!(least_gap_m(&obstacles, points) >= NavigatorSettings::default().safety_margin_m);
}

/// The nearest point is in the door: the robot cannot turn there.
#[test]
fn nearest_point_is_as_far_as_the_body_gets() {
    let obstacles = rooms(false);
    let mut planner = planner(|_| {});
    let error = planner.plan(&obstacles, START, GOAL, &mut || 0.0).expect_err("a crate");
    let PlanError::NoValidPath { nearest: Some(nearest), .. } = error else { panic!("{error}") };
    assert!(nearest.x > 6.0 && nearest.x < 6.5, "{nearest:?}");
    planner.plan(&obstacles, START, nearest, &mut || 0.0).expect("the named point is reachable");
}

/// A corridor of 2.4 m with a box of 0.6 m in its middle, or without it.
fn corridor(has_box: bool) -> ObstacleGrid {
    let frame = GridFrame { width: 400, height: 100, resolution_m: 0.05, origin: Pose::default() };
    ObstacleGrid::from_fn(frame, |cell| {
        let Point { x, y } = frame.center_of(cell);
        let is_box = (x - 10.0).abs() < 0.3 && (y - 2.5).abs() < 0.3;
        let is_room = (0.5..19.5).contains(&x) && (y - 2.5).abs() < 1.2;
        !is_room || has_box && is_box
    })
}

/// Marks of the box make the gaps beside it a cell narrower.
#[test]
fn robot_passes_a_box_in_a_corridor_that_the_map_does_not_show() {
    let (map, truth) = (corridor(false), Some(corridor(true)));
    let (start, goal) = (Pose::new(2.0, 2.5, 0.0), Goal::at(Point::new(18.0, 2.5)));
    let result = drive_among(&Config::default(), (&map, truth), start, &[goal]);
    assert!(result.reached && !result.collided, "{:?}", result.why());
    assert!(result.time_s < 75.0, "{} s", result.time_s);
}
