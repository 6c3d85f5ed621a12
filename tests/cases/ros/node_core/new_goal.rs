//! A new goal while the robot drives to another one.

use inbye::geometry::Point;
use inbye::ros::msg::ActionEnd;
use inbye::ros::node::IncomingMessage;

use super::action::{FIRST, navigate, summary};
use super::robot::{Robot, goal, grid, map};

const LATER: (f64, f64) = (9.0, 4.5);

fn send(robot: &mut Robot, (x, y): (f64, f64)) {
    robot.receive(&IncomingMessage::Goal(goal(x, y)));
}

fn away_m(robot: &Robot, (x, y): (f64, f64)) -> f64 {
    (robot.pose.position() - Point::new(x, y)).norm()
}

#[test]
fn robot_drives_on_while_it_plans_to_a_new_goal() {
    let mut robot = Robot::ready();
    robot.until(50, |robot| robot.speed() > 0.8);
    send(&mut robot, LATER);
    robot.until_published(20, 2);
    robot.until(600, |robot| robot.has_notice("reached the goal"));
    assert!(away_m(&robot, LATER) < 0.02, "{:?}", robot.pose);
    let stats = robot.core.stats();
    assert_eq!((stats.goals, stats.reached, stats.aborted), (2, 1, 1));
    assert!(robot.has_notice("driving to (9.00, 4.50)"), "{:?}", robot.notices);
}

#[test]
fn newest_of_several_goals_counts_and_so_does_the_newest_map() {
    let mut robot = Robot::ready();
    robot.until(50, |robot| robot.speed() > 0.8);
    send(&mut robot, (3.0, 4.5));
    send(&mut robot, (11.0, 4.5));
    send(&mut robot, LATER);
    robot.receive(&IncomingMessage::Map(map(&grid(24))));
    robot.until_planned(40, |robot| robot.has_notice("driving to (9.00, 4.50)"));
    robot.until(600, |robot| robot.has_notice("reached the goal"));
    assert!(away_m(&robot, LATER) < 0.02, "{:?}", robot.pose);
    let driving: Vec<_> =
        robot.notices.iter().filter(|notice| notice.contains("driving to")).collect();
    assert_eq!(driving.len(), 2, "{driving:?}");
    assert_eq!(robot.core.stats().goals, 4);
}

#[test]
fn new_goal_without_a_path_stops_the_robot() {
    let mut robot = Robot::with_map();
    robot.receive(&IncomingMessage::Goal(goal(10.0, 1.5)));
    robot.until(50, |robot| robot.speed() > 0.8);
    // Within the wall.
    robot.receive(&navigate(FIRST, 6.0, 2.0));
    robot.until_planned(50, |robot| !summary(robot).1.is_empty());
    let (_, status, code) = summary(&robot).1[0];
    assert_eq!((status, code), (ActionEnd::ABORTED, 206), "{:?}", robot.notices);
    robot.until(20, Robot::stands);
    assert_eq!(robot.core.stats().reached, 0);
}

/// The thread may have planned the path before the robot arrives at the last goal, or after.
#[test]
fn goal_that_comes_when_the_robot_arrives_at_the_last_one_is_reached_too() {
    let first = (3.0, 1.5);
    let arrival = |ticks: usize| {
        let mut robot = Robot::with_map();
        send(&mut robot, first);
        for _ in 0..ticks {
            robot.step();
        }
        robot
    };
    let mut robot = arrival(0);
    let ticks = robot.until(200, |robot| robot.has_notice("reached the goal"));
    for early in 0..4 {
        let mut robot = arrival(ticks - early);
        send(&mut robot, LATER);
        let reached = if early == 0 { 2 } else { 1 };
        robot.until(600, |robot| robot.core.stats().reached == reached);
        assert!(away_m(&robot, LATER) < 0.02, "{early}: {:?}", robot.pose);
    }
}
