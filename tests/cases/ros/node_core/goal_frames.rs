//! Goals in other frames than the map's.

use inbye::geometry::{Point, Pose};
use inbye::ros::msg;
use inbye::ros::node::{IncomingMessage, NodeSettings};
use inbye::runtime::PoseSource;

use super::action::{FIRST, navigate, summary};
use super::robot::{Robot, goal, grid, header, map, transform};

/// The frame of the odometry in the map.
const FRAME: Pose = Pose { x: 0.8, y: -0.3, yaw: 0.6 };

/// A robot whose odometry has a frame of its own, which `tf` gives, and the lidar's place.
fn robot() -> Robot {
    let mut robot = Robot::new(false);
    (robot.frame, robot.frame_at, robot.has_transform) = ("odom", FRAME, true);
    robot.mount = Pose::new(0.25, -0.1, 0.5);
    robot.publish_mount();
    robot
}

fn ready() -> Robot {
    let mut robot = robot();
    robot.receive(&IncomingMessage::Map(map(&grid(29))));
    (0..3).for_each(|_| assert_eq!(robot.step(), None));
    robot
}

/// A goal at a pose in a frame at a time, seconds; zero for the time of its arrival.
fn goal_in(frame: &str, pose: &Pose, stamp_s: f64) -> IncomingMessage {
    let pose = msg::Pose::from(pose);
    IncomingMessage::Goal(msg::PoseStamped { header: header(frame, stamp_s), pose })
}

/// Drives to the goal and checks where that is in the map.
#[track_caller]
fn assert_reached(robot: &mut Robot, expected: &Pose) {
    robot.until(600, |robot| robot.has_notice("reached the goal"));
    let away_m = (robot.pose.position() - expected.position()).norm();
    assert!(away_m < 0.03, "{:?} instead of {expected:?}: {:?}", robot.pose, robot.notices);
    assert!((robot.pose.yaw - expected.yaw).abs() < 0.1, "{:?}", robot.pose);
}

#[test]
fn goal_in_the_frame_of_odometry_robot_or_sensor_is_transformed() {
    let place = Pose::new(4.0, 2.5, 1.0);
    for frame in ["odom", "base_link", "laser"] {
        let mut robot = ready();
        let frame_at = match frame {
            "odom" => FRAME,
            "base_link" => robot.pose,
            _ => robot.pose.transform_pose(&robot.mount),
        };
        robot.receive(&goal_in(frame, &frame_at.inverse_transform_pose(&place), 0.0));
        robot.step();
        assert!(robot.has_notice("driving to (4.00, 2.50)"), "{frame}: {:?}", robot.notices);
        assert_reached(&mut robot, &place);
    }
}

/// A detection on the robot: the robot has driven on since.
#[test]
fn goal_in_the_frame_of_the_robot_counts_from_its_stamp() {
    let mut robot = ready();
    robot.receive(&IncomingMessage::Goal(goal(4.5, 1.5)));
    robot.until(50, |robot| robot.speed() > 0.5);
    let (then, stamp_s) = (robot.pose, robot.now_s);
    (0..5).for_each(|_| assert!(robot.step().is_some()));
    assert!((robot.pose.position() - then.position()).norm() > 0.2);
    robot.receive(&goal_in("base_link", &Pose::new(1.0, 1.0, 0.0), stamp_s));
    let Point { x, y } = then.transform(&Point::new(1.0, 1.0));
    robot.until_planned(50, |robot| robot.has_notice(&format!("driving to ({x:.2}, {y:.2})")));
}

#[test]
fn goal_in_another_frame_waits_for_the_first_map() {
    let place = Pose::new(4.0, 2.5, 1.0);
    let mut robot = robot();
    robot.receive(&goal_in("odom", &FRAME.inverse_transform_pose(&place), 1.0));
    robot.step();
    robot.step();
    robot.receive(&IncomingMessage::Map(map(&grid(29))));
    assert_reached(&mut robot, &place);
}

#[test]
fn goal_in_the_frame_of_odometry_uses_the_pose_that_the_node_measures() {
    let mut settings = NodeSettings::default();
    settings.config.pose_source = PoseSource::Scans;
    let mut robot = Robot::with_settings(settings);
    (robot.frame, robot.frame_at) = ("odom", FRAME);
    robot.core.operator().arm();
    robot.publish_mount();
    robot.receive(&IncomingMessage::Map(map(&grid(29))));
    let place = Pose::new(4.0, 2.5, 1.0);
    let message = goal_in("odom", &FRAME.inverse_transform_pose(&place), 0.0);
    // While the pose is unknown, nothing connects the two frames.
    robot.receive(&message);
    robot.step();
    assert!(
        robot.has_notice(
            "it is in the frame `odom`, whose pose in the map's frame `map` is not known"
        )
    );
    robot.until_planned(200, |robot| !robot.transforms.is_empty());
    robot.receive(&message);
    robot.until(600, |robot| robot.has_notice("reached the goal"));
    let away_m = (robot.pose.position() - place.position()).norm();
    assert!(away_m < 0.15, "{:?}", robot.pose);
}

#[test]
fn goal_in_an_unknown_frame_is_rejected_with_the_known_ones() {
    let mut robot = ready();
    let lamp = transform("ceiling", "lamp", &Pose::default(), 1.0);
    robot.receive(&IncomingMessage::StaticTransforms(lamp));
    robot.receive(&navigate(FIRST, 4.0, 2.5));
    robot.step();
    assert_eq!(summary(&robot).0, [(FIRST, true)]);
    robot.receive(&goal_in("lamp", &Pose::new(1.0, 0.0, 0.0), 1.0));
    robot.step();
    let text = "it is in the frame `lamp`, whose pose in the map's frame `map` is not known; known frames: base_link, laser, map, odom";
    assert!(robot.has_notice(text), "{:?}", robot.notices);
    // The goal before remains.
    assert!(summary(&robot).1.is_empty());
}

#[test]
fn goal_by_an_old_transform_or_odometry_is_rejected() {
    for frame in ["odom", "base_link"] {
        let mut robot = ready();
        (robot.has_transform, robot.has_odometry) = (frame != "odom", frame == "odom");
        (0..5).for_each(|_| assert_eq!(robot.step(), None));
        robot.receive(&goal_in(frame, &Pose::new(1.0, 0.0, 0.0), 0.0));
        robot.step();
        let text = format!("it is in the frame `{frame}`, whose pose in the map's frame");
        assert!(robot.has_notice(&text), "{:?}", robot.notices);
        assert_eq!(robot.core.stats().goals, 0);
    }
}

#[test]
fn map_in_another_frame_that_is_known_keeps_the_goal() {
    let mut robot = ready();
    let place = Pose::new(4.0, 2.5, 0.0);
    robot.receive(&goal_in("map", &place, 1.0));
    robot.until(50, |robot| robot.speed() > 0.3);
    let floor = transform("map", "floor", &Pose::default(), 1.0);
    robot.receive(&IncomingMessage::StaticTransforms(floor));
    let mut other = map(&grid(29));
    other.header.frame_id = "floor".into();
    robot.receive(&IncomingMessage::Map(other));
    assert_reached(&mut robot, &place);
    assert_eq!(robot.core.stats().aborted, 0);
}
