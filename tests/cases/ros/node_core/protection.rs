//! The protective layer of the node: arming, the operator's stop, and limits by the raw scan.

use inbye::base::OperatorState;
use inbye::geometry::{Pose, Twist};
use inbye::ros::msg::{Bool, DiagnosticStatus};
use inbye::ros::node::{IncomingMessage, NodeSettings};

use super::robot::{GOAL, Robot, goal};

fn arm(data: bool) -> IncomingMessage {
    IncomingMessage::Arm(Bool { data })
}

fn stop(data: bool) -> IncomingMessage {
    IncomingMessage::Stop(Bool { data })
}

/// The newest status in `diagnostics`.
fn status(robot: &Robot) -> &DiagnosticStatus {
    let newest = robot.diagnostics.last().and_then(|array| array.status.first());
    newest.expect("diagnostics")
}

fn value<'a>(status: &'a DiagnosticStatus, key: &str) -> &'a str {
    let found = status.values.iter().find(|value| value.key == key);
    found.map_or("", |found| &found.value)
}

#[test]
fn goal_does_not_arm_the_robot_and_an_arm_message_does() {
    let mut robot = Robot::unarmed(false).with_goal();
    (0..120).for_each(|_| assert_eq!(robot.step(), Some(Twist::STOP)));
    assert_eq!(robot.core.operator().state(), OperatorState::NotArmed);
    assert!(robot.paths.is_empty(), "{}", robot.paths.len());
    let not_armed = robot.notices.iter().filter(|notice| notice.contains("not armed"));
    assert_eq!(not_armed.count(), 1, "{:?}", robot.notices);
    let shown = status(&robot);
    assert_eq!((shown.level, shown.message.as_str()), (DiagnosticStatus::WARN, "not armed"));
    assert_eq!((value(shown, "operator"), value(shown, "action")), ("not_armed", "not_armed"));
    // Once a second, and not at each tick.
    assert!((11..=14).contains(&robot.diagnostics.len()), "{}", robot.diagnostics.len());
    for message in [arm(false), stop(false), IncomingMessage::Goal(goal(GOAL.0, GOAL.1))] {
        robot.receive(&message);
        assert_eq!(robot.step(), Some(Twist::STOP), "{message:?}");
    }
    robot.receive(&arm(true));
    robot.until(600, |robot| robot.has_notice("reached the goal"));
    assert_eq!(robot.core.stats().protective_actions["not_armed"], 123);
}

#[test]
fn robot_without_a_goal_reports_that_it_is_not_armed() {
    let mut robot = Robot::unarmed(false);
    assert_eq!(robot.step(), None);
    assert!(robot.has_notice("not armed: the robot stands until an operator arms it"));
    assert_eq!(value(status(&robot), "operator"), "not_armed");
    robot.core.operator().arm();
    robot.step();
    assert!(robot.has_notice("armed: the robot drives to its goals"));
    assert_eq!(
        (status(&robot).level, value(status(&robot), "action")),
        (DiagnosticStatus::OK, "pass")
    );
}

#[test]
fn stop_is_zero_at_the_next_tick_and_stays_until_the_robot_is_armed_again() {
    for by_message in [true, false] {
        let mut robot = Robot::ready();
        robot.until(50, |robot| robot.speed() > 0.8);
        if by_message {
            robot.receive(&stop(true));
        } else {
            robot.core.operator().stop();
        }
        let steps = 120;
        (0..steps).for_each(|_| assert_eq!(robot.step(), Some(Twist::STOP)));
        assert_eq!(value(status(&robot), "operator"), "stopped");
        // Neither a new goal nor the end of the stop message arms it, and a stop is no longer a mere disarming.
        for message in [stop(false), arm(false), IncomingMessage::Goal(goal(GOAL.0, GOAL.1))] {
            robot.receive(&message);
            assert_eq!(robot.step(), Some(Twist::STOP), "{message:?}");
        }
        assert_eq!(robot.core.operator().state(), OperatorState::Stopped);
        robot.receive(&arm(true));
        let mut before = 0.0;
        for _ in 0..5 {
            robot.step();
            // A control period and the latency at 1 m/s^2.
            assert!(robot.speed() - before < 0.2, "{before} to {}", robot.speed());
            before = robot.speed();
        }
        robot.until(600, |robot| robot.has_notice("reached the goal"));
        assert_eq!(robot.core.stats().protective_actions["operator_stop"], 123);
        let stopped = robot.notices.iter().filter(|notice| notice.contains("stopped by the"));
        assert_eq!(stopped.count(), 1);
    }
}

/// A robot with a fixed stop zone of 2 m width, from 0.4 to 2 m ahead. With sums and this horizon it drives at the wall for longer, so that the
/// zone reaches the wall before the robot turns.
fn with_zone(mount: Pose) -> Robot {
    let mut settings = NodeSettings::default();
    let zone = "[local]\nnormalization = \"sum\"\nsim_time_s = 3.0\n[[collision_monitor.polygons]]\nname = \"ahead\"\naction_type = \"stop\"\n\
        points = [[0.4, 1.0], [2.0, 1.0], [2.0, -1.0], [0.4, -1.0]]\n";
    settings.config = toml::from_str(zone).expect("settings");
    let mut robot = Robot::with_settings(settings);
    robot.core.operator().arm();
    robot.mount = mount;
    robot.with_goal()
}

#[test]
fn stop_zone_acts_on_the_raw_scan_in_the_robots_frame() {
    let mut places_m = Vec::new();
    for mount in [Pose::default(), Pose::new(0.25, -0.1, 2.0)] {
        let mut robot = with_zone(mount);
        // The navigator drives around the end of the wall at (5.8, 3.0) m.
        robot.until(100, |robot| robot.has_notice("protection: zone: the zone ahead"));
        places_m.push(robot.pose.x);
        // It brakes by its limits, and stands.
        let began = robot.speed();
        robot.until(15, Robot::stands);
        assert!(began > 0.2 && robot.pose.x < 5.8, "{mount:?}: {began}, {:?}", robot.pose);
        assert_eq!(value(status(&robot), "action"), "zone");
        assert_eq!(status(&robot).level, DiagnosticStatus::WARN);
        let zone = robot.notices.iter().filter(|notice| notice.contains("protection: zone"));
        assert_eq!(zone.count(), 1, "{:?}", robot.notices);
    }
    // At the same place before the wall, wherever the lidar is on the robot.
    assert!(places_m.iter().all(|place_m| (3.0..5.4).contains(place_m)), "{places_m:?}");
    assert!((places_m[0] - places_m[1]).abs() < 0.25, "{places_m:?}");
}

#[test]
fn missing_scans_stop_the_robot_by_their_age() {
    let mut robot = Robot::ready();
    robot.until(50, |robot| robot.speed() > 0.8);
    robot.has_scan = false;
    robot.until(20, |robot| robot.has_notice("protection: stale_scan"));
    assert_eq!(robot.core.stats().protective_actions.get("no_scan"), None);
    robot.until(15, Robot::stands);
    robot.has_scan = true;
    robot.until(600, |robot| robot.has_notice("reached the goal"));
    assert!(robot.has_notice("protection: pass"), "{:?}", robot.notices);
}
