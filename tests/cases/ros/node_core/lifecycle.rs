//! The node as a managed one.

use inbye::geometry::Twist;
use inbye::ros::msg::LifecycleRequest;
use inbye::ros::node::{IncomingMessage, LifecycleState, NodeSettings};

use super::robot::{GOAL, Robot, goal, grid, map};

const CONFIGURE: u8 = 1;
const CLEANUP: u8 = 2;
const ACTIVATE: u8 = 3;
const DEACTIVATE: u8 = 4;
const ACTIVE_SHUTDOWN: u8 = 7;

/// Requests a transition; returns the answer: the transition that took place, and the state.
fn change(robot: &mut Robot, request: u64, transition: u8) -> (u8, u8) {
    robot.receive(&IncomingMessage::ChangeState(LifecycleRequest { request, transition }));
    robot.step();
    let answer = robot.states.last().expect("an answer");
    assert_eq!(answer.request, request);
    (answer.transition, answer.state)
}

#[test]
fn managed_node_pursues_goals_only_while_it_is_active() {
    let mut settings = NodeSettings::default();
    settings.is_managed = true;
    let mut robot = Robot::with_settings(settings);
    robot.core.operator().arm();
    robot.publish_mount();
    robot.receive(&IncomingMessage::Map(map(&grid(29))));
    let to_goal = IncomingMessage::Goal(goal(GOAL.0, GOAL.1));
    robot.receive(&to_goal);
    assert_eq!(change(&mut robot, 1, ACTIVATE), (0, 1), "it is not configured");
    assert_eq!(change(&mut robot, 2, CONFIGURE), (CONFIGURE, 2));
    robot.receive(&to_goal);
    (0..5).for_each(|_| assert_eq!(robot.step(), None));
    assert_eq!(robot.core.stats().rejected["goal_pose"], 2);
    assert!(robot.has_notice("the node is unconfigured: its lifecycle manager"));
    assert_eq!(change(&mut robot, 3, ACTIVATE), (ACTIVATE, 3));
    robot.receive(&to_goal);
    robot.until(50, |robot| robot.speed() > 0.8);
    // It brakes, and forgets the goal.
    assert_eq!(change(&mut robot, 4, DEACTIVATE), (DEACTIVATE, 2));
    assert!(robot.speed() > 0.5);
    robot.until(30, Robot::stands);
    robot.until(30, |robot| robot.commands.last() == Some(&None));
    assert_eq!(robot.core.stats().aborted, 1);
    assert_eq!(change(&mut robot, 5, CLEANUP), (CLEANUP, 1));
    assert_eq!(change(&mut robot, 6, CONFIGURE), (CONFIGURE, 2));
    assert_eq!(change(&mut robot, 7, ACTIVATE), (ACTIVATE, 3));
    robot.receive(&to_goal);
    robot.until(600, |robot| robot.has_notice("reached the goal"));
    assert_eq!(robot.core.lifecycle(), LifecycleState::Active);
}

#[test]
fn node_that_is_shut_down_ends_when_the_robot_stands() {
    let mut robot = Robot::ready();
    assert_eq!(robot.core.lifecycle(), LifecycleState::Active);
    robot.until(50, |robot| robot.speed() > 0.8);
    assert_eq!(change(&mut robot, 1, ACTIVE_SHUTDOWN), (ACTIVE_SHUTDOWN, 4));
    assert!(!robot.core.has_ended());
    robot.until(30, |robot| robot.core.has_ended());
    assert_eq!(robot.commands.last(), Some(&Some(Twist::STOP)));
}
