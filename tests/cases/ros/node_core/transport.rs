//! A transport that is lost and restored: zeros first, then the goal of the topic.

use inbye::geometry::Twist;
use inbye::ros::msg::{ActionEnd, ActionResultRequest};
use inbye::ros::node::{ActionUpdate, IncomingMessage};

use super::action::{FIRST, SECOND, cancel, navigate, pursuing, summary};
use super::robot::{GOAL, Robot};

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

/// The new network process does not know the goal, and the client has lost its result.
#[test]
fn goal_of_the_action_ends_with_the_transport_and_the_new_one_gets_its_end() {
    let mut robot = pursuing();
    robot.core.transport_lost();
    (robot.has_scan, robot.has_odometry) = (false, false);
    (0..10).for_each(|_| assert_eq!(robot.step(), Some(Twist::STOP)));
    robot.core.transport_restored(robot.now_s);
    (robot.has_scan, robot.has_odometry) = (true, true);
    robot.actions.clear();
    robot.step();
    let end = (vec![(FIRST, true)], vec![(FIRST, ActionEnd::ABORTED, 9000)], vec![]);
    assert_eq!(summary(&robot), end);
    assert!(robot.has_notice("aborted the goal: the network process was restarted"));
    (0..60).for_each(|_| assert!(robot.step().is_none_or(|command| command == Twist::STOP)));
    // Lost again without a goal: the last end is still known.
    robot.core.transport_lost();
    robot.core.transport_restored(robot.now_s);
    robot.actions.clear();
    robot.step();
    assert_eq!(summary(&robot), end);
    robot.receive(&navigate(SECOND, GOAL.0, GOAL.1));
    robot.until(50, |robot| robot.speed() > 0.8);
}

/// A client that asked for the result before the loss waits for it: the new network process answers, but only once.
#[test]
fn open_request_for_a_result_is_answered_after_the_transport_is_back() {
    let request = |number: i64, id: [u8; 16]| ActionResultRequest { client: [9; 16], number, id };
    let answered = |robot: &Robot| -> Vec<ActionResultRequest> {
        let results = robot.actions.iter().filter_map(|update| match update {
            ActionUpdate::Result(request) => Some(*request),
            _ => None,
        });
        results.collect()
    };
    let mut robot = pursuing();
    for (number, id) in [(1, FIRST), (2, SECOND)] {
        robot.receive(&IncomingMessage::ResultRequest(request(number, id)));
    }
    for _ in 0..2 {
        robot.core.transport_lost();
        (0..3).for_each(|_| assert_eq!(robot.step(), Some(Twist::STOP)));
        robot.core.transport_restored(robot.now_s);
        // The nodes do not know each other yet.
        (0..40).for_each(|_| assert_eq!(robot.step(), Some(Twist::STOP)));
        assert!(answered(&robot).is_empty());
    }
    robot.until(20, |robot| !answered(robot).is_empty());
    assert_eq!(answered(&robot), [request(1, FIRST)]);
    // The network process answers those for a goal that ends while it lives.
    robot.receive(&navigate(SECOND, GOAL.0, GOAL.1));
    robot.receive(&IncomingMessage::ResultRequest(request(3, SECOND)));
    robot.until(50, |robot| robot.speed() > 0.8);
    robot.receive(&navigate([3; 16], 2.0, 4.0));
    robot.step();
    robot.core.transport_lost();
    robot.core.transport_restored(robot.now_s);
    (0..60).for_each(|_| {
        robot.step();
    });
    assert_eq!(answered(&robot), [request(1, FIRST)]);
}

#[test]
fn cancelled_goal_ends_as_cancelled_when_the_transport_is_lost() {
    let mut robot = pursuing();
    robot.receive(&cancel(1, FIRST));
    robot.core.transport_lost();
    robot.core.transport_restored(robot.now_s);
    robot.step();
    assert_eq!(summary(&robot).1, [(FIRST, ActionEnd::CANCELED, 0)]);
}
