//! A transport that is lost and restored: zeros first, then the goal.

use inbye::geometry::Twist;

use super::robot::Robot;

#[test]
fn robot_gets_zeros_after_the_transport_is_back_and_then_continues() {
    let mut robot = Robot::ready();
    robot.until(50, |robot| robot.speed() > 0.8);
    robot.core.transport_lost();
    (robot.has_scan, robot.has_odometry) = (false, false);
    (0..10).for_each(|_| assert_eq!(robot.step(), Some(Twist::STOP)));
    robot.core.transport_restored(robot.now_s);
    (robot.has_scan, robot.has_odometry) = (true, true);
    // 2 s of zeros once all inputs are there: the base may not know the node yet.
    (0..20).for_each(|_| assert_eq!(robot.step(), Some(Twist::STOP)));
    robot.until(10, |robot| robot.speed() > 0.0);
    robot.until(600, |robot| robot.has_notice("reached the goal"));
}

#[test]
fn goal_that_ends_without_a_transport_publishes_zeros_when_it_is_back() {
    let mut robot = Robot::ready();
    robot.until(600, |robot| robot.has_notice("reached the goal"));
    robot.core.transport_lost();
    // Beyond the second of zeros after a goal.
    (0..50).for_each(|_| assert_eq!(robot.step(), Some(Twist::STOP)));
    robot.core.transport_restored(robot.now_s);
    let zeros = robot.until(100, |robot| robot.commands.last() == Some(&None));
    assert!((48..=55).contains(&zeros), "{zeros}");
}

#[test]
fn node_without_goal_stays_silent_after_a_loss() {
    let mut robot = Robot::ready();
    robot.until(900, |robot| robot.commands.last() == Some(&None));
    robot.core.transport_lost();
    robot.core.transport_restored(robot.now_s);
    (0..20).for_each(|_| assert_eq!(robot.step(), None));
}
