//! The action `navigate_to_pose` without DDS.

use inbye::geometry::Twist;
use inbye::ros::msg::{
    ActionCancel, ActionEnd, ActionFeedback, ActionGoal, NavigateToPoseGoal, Time,
};
use inbye::ros::node::{ActionUpdate, IncomingMessage};

use super::robot::{GOAL, Robot, goal};

pub const FIRST: [u8; 16] = [1; 16];
pub const SECOND: [u8; 16] = [2; 16];

pub fn navigate(id: [u8; 16], x: f64, y: f64) -> IncomingMessage {
    let goal = NavigateToPoseGoal { pose: goal(x, y), behavior_tree: String::new() };
    IncomingMessage::Navigate(Box::new(ActionGoal { id, goal }))
}

pub fn cancel(request: u64, id: [u8; 16]) -> IncomingMessage {
    cancel_until(request, id, 0.0)
}

/// A request to cancel the goals that were accepted at a time, seconds, or before.
fn cancel_until(request: u64, id: [u8; 16], time_s: f64) -> IncomingMessage {
    let stamp = Time::from_seconds(time_s);
    IncomingMessage::Cancel(ActionCancel { request, id, stamp })
}

/// Identities and answers, identities and statuses of ends with their codes, and answers to requests to cancel.
pub type Summary = (Vec<([u8; 16], bool)>, Vec<([u8; 16], i8, u16)>, Vec<(u64, bool)>);

pub fn summary(robot: &Robot) -> Summary {
    let (mut answers, mut ends, mut cancels) = Summary::default();
    for update in &robot.actions {
        match update {
            ActionUpdate::Answer(answer) => answers.push((answer.id, answer.accepted)),
            ActionUpdate::End(end) => ends.push((end.id, end.status, end.result.error_code)),
            ActionUpdate::CancelAnswer(answer) => cancels.push((answer.request, answer.accepted)),
            _ => {}
        }
    }
    (answers, ends, cancels)
}

fn feedback(robot: &Robot) -> Vec<&ActionFeedback> {
    let mut all = Vec::new();
    for update in &robot.actions {
        if let ActionUpdate::Feedback(feedback) = update {
            all.push(feedback);
        }
    }
    all
}

/// A robot at speed on the way to the goal of the first client.
pub fn pursuing() -> Robot {
    let mut robot = Robot::with_map();
    robot.receive(&navigate(FIRST, GOAL.0, GOAL.1));
    robot.until(50, |robot| robot.speed() > 0.8);
    robot
}

#[test]
fn goal_is_accepted_pursued_with_feedback_and_succeeds() {
    let mut robot = Robot::with_map();
    robot.receive(&navigate(FIRST, GOAL.0, GOAL.1));
    robot.until(600, |robot| robot.has_notice("reached the goal"));
    let (answers, ends, _) = summary(&robot);
    assert_eq!(answers, [(FIRST, true)]);
    assert_eq!(ends, [(FIRST, ActionEnd::SUCCEEDED, 0)]);
    let feedback = feedback(&robot);
    assert!(feedback.len() > 30, "{}", feedback.len());
    let remaining: Vec<f32> = feedback.iter().map(|it| it.feedback.distance_remaining).collect();
    assert!(
        remaining[0] > 8.0 && remaining.last().is_some_and(|left| *left < 0.3),
        "{remaining:?}"
    );
    let last = &feedback[feedback.len() - 1].feedback;
    assert!(
        libm::hypot(
            last.current_pose.pose.position.x - GOAL.0,
            last.current_pose.pose.position.y - GOAL.1
        ) < 0.3
    );
    assert!(last.navigation_time.sec >= 9 && last.current_pose.header.frame_id == "map");
    // The next one.
    robot.receive(&navigate(SECOND, 2.0, 4.0));
    robot.until(900, |robot| robot.core.stats().reached == 2);
    assert_eq!(summary(&robot).1[1], (SECOND, ActionEnd::SUCCEEDED, 0));
}

#[test]
fn cancelled_goal_ends_when_the_robot_stands() {
    let mut robot = pursuing();
    robot.receive(&cancel(7, SECOND));
    robot.receive(&cancel(8, FIRST));
    robot.step();
    let (_, ends, cancels) = summary(&robot);
    assert_eq!(cancels, [(7, false), (8, true)]);
    assert!(ends.is_empty() && robot.speed() > 0.5, "it brakes: {ends:?}");
    let steps = robot.until(30, Robot::stands);
    assert!(steps > 3);
    assert_eq!(summary(&robot).1, [(FIRST, ActionEnd::CANCELED, 0)]);
    robot.until(30, |robot| robot.commands.last() == Some(&None));
    // Nothing is left to be cancelled, and another goal is pursued. Zeros name every goal.
    robot.receive(&cancel(9, FIRST));
    robot.receive(&navigate(SECOND, GOAL.0, GOAL.1));
    robot.until(50, |robot| robot.speed() > 0.5);
    robot.receive(&cancel(10, [0; 16]));
    robot.until(40, |robot| summary(robot).1.len() == 2);
    assert_eq!(summary(&robot).2[2..], [(9, false), (10, true)]);
    assert_eq!(robot.commands.last(), Some(&Some(Twist::STOP)));
}

/// As in `action_msgs/CancelGoal`: with a time, the goals that were accepted at it or before it are cancelled too.
#[test]
fn cancel_with_a_time_stops_only_the_goals_accepted_until_then() {
    for (id, after_s, is_cancelled) in [
        ([0; 16], -0.1, false),
        ([0; 16], 0.0, true),
        ([0; 16], 5.0, true),
        (FIRST, -0.1, true),
        (SECOND, -0.1, false),
        (SECOND, 0.0, true),
    ] {
        let mut robot = Robot::with_map();
        let accepted_s = robot.now_s;
        robot.receive(&navigate(FIRST, GOAL.0, GOAL.1));
        robot.until(50, |robot| robot.speed() > 0.8);
        robot.receive(&cancel_until(1, id, accepted_s + after_s));
        (0..30).for_each(|_| {
            robot.step();
        });
        let (_, ends, cancels) = summary(&robot);
        assert_eq!(cancels, [(1, is_cancelled)], "{id:?} {after_s}");
        assert_eq!((robot.speed() == 0.0, !ends.is_empty()), (is_cancelled, is_cancelled));
    }
}

/// In Nav2 a goal of the topic goes through the action.
#[test]
fn cancel_of_every_goal_stops_a_goal_of_the_topic() {
    for (id, after_s, is_cancelled) in [
        ([0; 16], None, true),
        ([0; 16], Some(0.0), true),
        ([0; 16], Some(-0.1), false),
        (FIRST, None, false),
        (FIRST, Some(0.0), true),
    ] {
        let mut robot = Robot::with_map();
        let until_s = after_s.map_or(0.0, |after_s: f64| robot.now_s + after_s);
        robot.receive(&IncomingMessage::Goal(goal(GOAL.0, GOAL.1)));
        robot.until(50, |robot| robot.speed() > 0.8);
        robot.receive(&cancel_until(1, id, until_s));
        (0..30).for_each(|_| {
            robot.step();
        });
        let (_, ends, cancels) = summary(&robot);
        assert_eq!((ends.len(), cancels), (0, vec![(1, is_cancelled)]), "{id:?} {after_s:?}");
        assert_eq!(robot.speed() == 0.0, is_cancelled, "{:?}", robot.notices);
    }
}

#[test]
fn newer_goal_aborts_the_older_one() {
    let mut robot = Robot::with_map();
    robot.receive(&navigate(FIRST, GOAL.0, GOAL.1));
    robot.until(50, |robot| robot.speed() > 0.5);
    robot.receive(&navigate(SECOND, 2.0, 4.0));
    robot.step();
    assert_eq!(summary(&robot).1, [(FIRST, ActionEnd::ABORTED, 9000)]);
    // A goal on the topic does the same.
    robot.receive(&IncomingMessage::Goal(goal(GOAL.0, GOAL.1)));
    robot.step();
    assert_eq!(summary(&robot).1[1], (SECOND, ActionEnd::ABORTED, 9000));
    robot.until(900, |robot| robot.has_notice("reached the goal"));
    assert_eq!(summary(&robot).1.len(), 2);
    let stats = robot.core.stats();
    assert_eq!((stats.goals, stats.reached, stats.aborted), (3, 1, 2));
}

#[test]
fn goal_without_a_path_is_aborted_with_its_code_and_an_invalid_one_rejected() {
    let mut robot = Robot::with_map();
    robot.receive(&navigate(FIRST, 40.0, 1.5));
    robot.step();
    let (answers, ends, _) = summary(&robot);
    assert_eq!((answers, ends), (vec![(FIRST, true)], vec![(FIRST, ActionEnd::ABORTED, 204)]));
    robot.receive(&navigate(SECOND, f64::NAN, 1.5));
    robot.step();
    assert_eq!(summary(&robot).0[1], (SECOND, false));
    assert_eq!(robot.core.stats().rejected["navigate_to_pose"], 1);
}

#[test]
fn cancelled_goal_that_is_replaced_ends_as_cancelled() {
    let mut robot = pursuing();
    robot.receive(&cancel(1, FIRST));
    robot.receive(&navigate(SECOND, 2.0, 4.0));
    robot.step();
    assert_eq!(summary(&robot).1, [(FIRST, ActionEnd::CANCELED, 0)]);
}

#[test]
fn node_that_is_stopped_ends_its_goal() {
    for (is_cancelled, status, code) in
        [(false, ActionEnd::ABORTED, 9000), (true, ActionEnd::CANCELED, 0)]
    {
        let mut robot = pursuing();
        if is_cancelled {
            robot.receive(&cancel(1, FIRST));
        }
        let outgoing = robot.core.shut_down(robot.now_s);
        assert_eq!(outgoing.command, Some(Twist::STOP));
        robot.actions.extend(outgoing.action);
        assert_eq!(summary(&robot).1, [(FIRST, status, code)]);
        assert_eq!(robot.core.stats().aborted, u64::from(!is_cancelled));
    }
}

#[test]
fn same_goal_again_does_not_stop_the_robot() {
    let mut robot = pursuing();
    robot.receive(&navigate(SECOND, GOAL.0 + 0.02, GOAL.1));
    robot.step();
    assert_eq!(summary(&robot).1, [(FIRST, ActionEnd::ABORTED, 9000)]);
    for step in 0..20 {
        if step % 2 == 0 {
            robot.receive(&navigate([10 + step; 16], GOAL.0, GOAL.1 - 0.02));
        }
        robot.step();
        assert!(robot.speed() > 0.5, "{step}: {:?}", robot.notices);
    }
    assert_eq!(robot.paths.len(), 1);
    robot.until(600, |robot| robot.has_notice("reached the goal"));
    assert_eq!(summary(&robot).1.last(), Some(&([28; 16], ActionEnd::SUCCEEDED, 0)));
}
