//! A map that is published while the robot drives, and that has no path to its goal.

use std::thread;
use std::time::Duration;

use inbye::geometry::{Point, Pose};
use inbye::map::{Cell, OccupancyGrid};
use inbye::ros::msg::ActionEnd;
use inbye::ros::node::IncomingMessage;

use super::action::{FIRST, navigate, summary};
use super::robot::{GOAL, Robot, grid, map, transform};

/// The code with which a goal ends after the map was replaced by one with these occupied cells, and the distance driven until then,
/// metres.
fn end_on_map(occupied: impl Iterator<Item = Cell>) -> (u16, f64) {
    let mut robot = Robot::with_map();
    robot.receive(&navigate(FIRST, GOAL.0, GOAL.1));
    robot.until(100, |robot| robot.speed() > 0.4);
    let before = grid(29);
    let mut cells = before.cells().to_vec();
    occupied.for_each(|cell| cells[before.frame().index(cell)] = 100);
    robot.receive(&IncomingMessage::Map(map(&OccupancyGrid::new(*before.frame(), cells))));
    let from = robot.pose.position();
    robot.until_planned(100, |robot| !summary(robot).1.is_empty());
    let (_, status, code) = summary(&robot).1[0];
    assert_eq!(status, ActionEnd::ABORTED);
    (code, (robot.pose.position() - from).norm())
}

#[test]
fn map_that_covers_the_goal_ends_it() {
    let at = grid(29).frame().cell_of(&Point::new(GOAL.0, GOAL.1)).expect("inside");
    let around =
        |row: i32| (at.column - 2..at.column + 3).map(move |column| Cell::new(column, row));
    let (code, driven_m) = end_on_map((at.row - 2..at.row + 3).flat_map(around));
    assert!(code == 206 && driven_m < 2.0, "{code} after {driven_m} m");
}

#[test]
fn map_that_closes_the_way_ends_the_goal() {
    let height = grid(29).frame().height as i32;
    let (code, driven_m) = end_on_map((0..height).map(|row| Cell::new(33, row)));
    assert!(code == 208 && driven_m < 2.0, "{code} after {driven_m} m");
}

/// Such a robot looks for a way out, for a long time on a map without a free cell.
#[test]
fn map_that_is_unknown_at_the_robot_is_reported_once() {
    let mut robot = Robot::ready();
    robot.until(50, |robot| robot.speed() > 0.5);
    let mut unknown = map(&grid(29));
    unknown.data.fill(-1);
    for value in [-1, 100] {
        unknown.data[0] = value;
        robot.receive(&IncomingMessage::Map(unknown.clone()));
        robot.step();
    }
    let words = "the place of the robot is occupied or unknown on the new map";
    let count = robot.notices.iter().filter(|notice| notice.contains(words)).count();
    assert_eq!(count, 1, "{:?}", robot.notices);
}

#[test]
fn pose_outside_the_map_ends_the_goal() {
    let mut robot = Robot::with_map();
    robot.frame = "odom";
    robot.receive(&navigate(FIRST, GOAL.0, GOAL.1));
    let step = |robot: &mut Robot, x: f64| {
        let at = transform("map", "odom", &Pose::new(x, 0.0, 0.0), robot.now_s);
        robot.receive(&IncomingMessage::Transforms(at));
        robot.step();
    };
    (0..30).for_each(|_| step(&mut robot, 0.0));
    assert!(robot.speed() > 0.4, "{:?}", robot.notices);
    for tick in 0..100 {
        step(&mut robot, 40.0);
        thread::sleep(Duration::from_millis(tick));
        if let Some((_, _, code)) = summary(&robot).1.first() {
            assert_eq!(*code, 203, "{:?}", robot.notices);
            return;
        }
    }
    panic!("no end: {:?}", robot.notices);
}
