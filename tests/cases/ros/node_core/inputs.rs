//! Inputs that are missing or do not fit, and what the node tells of them.

use inbye::geometry::{Pose, Twist};
use inbye::ros::msg::{CostmapFilterInfo, DiagnosticStatus, OccupancyGrid, Quaternion, TFMessage};
use inbye::ros::node::IncomingMessage;

use super::robot::{GOAL, Robot, goal, grid, map, transform};

const INPUTS: &str = "inbye: inputs";

/// A transform with a pitch upwards, radians.
fn pitched(parent: &str, child: &str, pose: &Pose, pitch: f64) -> TFMessage {
    let mut message = transform(parent, child, pose, 1.0);
    let (sin, cos) = libm::sincos(-pitch / 2.0);
    message.transforms[0].transform.rotation = Quaternion { x: 0.0, y: sin, z: 0.0, w: cos };
    message
}

#[test]
fn diagnostics_name_the_missing_input_without_a_goal() {
    let mut robot = Robot::new(false);
    (robot.has_scan, robot.has_odometry) = (false, false);
    robot.publish_mount();
    for missing in ["no map was received", "no odometry was received", "no scan was received"] {
        (0..11).for_each(|_| assert_eq!(robot.step(), None));
        let waiting = format!("waiting: {missing}");
        assert_eq!(robot.status(INPUTS), (DiagnosticStatus::WARN, &*waiting));
        match missing {
            "no map was received" => robot.receive(&IncomingMessage::Map(map(&grid(29)))),
            "no odometry was received" => robot.has_odometry = true,
            _ => robot.has_scan = true,
        }
    }
    robot.step();
    assert_eq!(robot.status(INPUTS).0, DiagnosticStatus::OK);
    robot.has_scan = false;
    (0..20).for_each(|_| assert_eq!(robot.step(), None));
    assert_eq!(robot.status(INPUTS).1, "waiting: scans are no longer received");
    assert!(robot.notices.iter().all(|notice| !notice.contains("waiting")));
}

/// Servers send maps and masks once: the robot would drive by the map before without a sign.
#[test]
fn diagnostics_name_a_rejected_map_or_mask_until_a_valid_one_comes() {
    for (incoming, topic) in [
        (IncomingMessage::Map as fn(OccupancyGrid) -> IncomingMessage, "map"),
        (IncomingMessage::KeepoutMask, "keepout_filter_mask"),
        (IncomingMessage::SpeedMask, "speed_filter_mask"),
    ] {
        let mut robot = Robot::with_map();
        let mut mask = map(&grid(29));
        if topic != "map" {
            mask.data.fill(0);
        }
        robot.step();
        assert_eq!(robot.status(INPUTS).0, DiagnosticStatus::OK);
        let mut broken = mask.clone();
        broken.data[7] = -2;
        robot.receive(&incoming(broken));
        robot.step();
        let (level, message) = robot.status(INPUTS);
        let words = format!("the newest message on {topic} is rejected and not used: cell 7 is -2");
        assert!(message.starts_with(&words), "{message}");
        assert_eq!(level, DiagnosticStatus::WARN);
        robot.has_scan = false;
        (0..11).for_each(|_| assert_eq!(robot.step(), None));
        let (_, message) = robot.status(INPUTS);
        assert!(
            message.starts_with("waiting: scans are ") && message.contains(&words),
            "{message}"
        );
        robot.has_scan = true;
        robot.receive(&incoming(mask));
        robot.receive(&IncomingMessage::FilterInfo(CostmapFilterInfo {
            r#type: CostmapFilterInfo::SPEED_PERCENT,
            filter_mask_topic: "speed_filter_mask".to_owned(),
            ..CostmapFilterInfo::default()
        }));
        robot.step();
        assert_eq!(robot.status(INPUTS), (DiagnosticStatus::OK, "all inputs are received"));
    }
}

#[test]
fn node_that_receives_nothing_says_so_once() {
    let mut robot = Robot::new(false);
    (robot.has_scan, robot.has_odometry) = (false, false);
    (0..300).for_each(|_| assert_eq!(robot.step(), None));
    let silent = robot.notices.iter().filter(|notice| notice.contains("check ROS_DOMAIN_ID"));
    assert_eq!(silent.count(), 1, "{:?}", robot.notices);
    let mut other = Robot::new(false);
    (0..300).for_each(|_| assert_eq!(other.step(), None));
    assert!(!other.has_notice("check ROS_DOMAIN_ID"));
}

#[test]
fn tilted_lidar_is_rejected() {
    for (degrees, is_used) in [(9.0_f64, true), (11.0, false), (45.0, false)] {
        let mut robot = Robot::new(false);
        robot.receive(&IncomingMessage::Map(map(&grid(29))));
        robot.receive(&IncomingMessage::Goal(goal(GOAL.0, GOAL.1)));
        let mount = pitched("base_link", "laser", &Pose::default(), degrees.to_radians());
        robot.receive(&IncomingMessage::StaticTransforms(mount));
        (0..10).for_each(|_| {
            robot.step();
        });
        assert_eq!(robot.speed() > 0.1, is_used, "{degrees}: {:?}", robot.notices);
        assert_eq!(robot.has_notice("must be level within 10 degrees"), !is_used, "{degrees}");
    }
}

/// Some drivers fill in only the pose. The robot would count as standing while it drives.
#[test]
fn odometry_without_a_speed_is_rejected_and_the_robot_stands() {
    let mut robot = Robot::ready();
    robot.speed_share = 0.0;
    robot.until(30, |robot| robot.has_notice("its pose moves, but its speed (twist) is zero"));
    robot.until(20, Robot::stands);
    (0..50).for_each(|_| assert_eq!(robot.step(), Some(Twist::STOP)));
    assert_eq!(robot.status(INPUTS).0, DiagnosticStatus::WARN);
}

/// `base_link` and `laser` may be children of one frame, and a localization may publish the map below the odometry.
#[test]
fn frames_are_connected_by_a_common_one() {
    let place = Pose::new(0.8, -0.3, 0.6);
    let mut robot = Robot::new(false);
    (robot.frame, robot.frame_at) = ("odom", place);
    robot.mount = Pose::new(0.25, -0.1, 2.0);
    let body = Pose::new(0.1, 0.0, 0.5);
    let messages = [
        transform("body", "base_link", &body, 1.0),
        transform("body", "laser", &body.transform_pose(&robot.mount), 1.0),
        transform("odom", "map", &place.inverse_transform_pose(&Pose::default()), 1.0),
    ];
    for message in messages {
        robot.receive(&IncomingMessage::StaticTransforms(message));
    }
    robot.receive(&IncomingMessage::Map(map(&grid(29))));
    robot.receive(&IncomingMessage::Goal(goal(GOAL.0, GOAL.1)));
    robot.until(600, |robot| robot.has_notice("reached the goal"));
    assert!(robot.away_m() < 0.02, "{:?}", robot.pose);
}

#[test]
fn notice_of_odometry_that_tf_tilts_or_does_not_connect_names_the_cause() {
    let mut robot = Robot::ready();
    robot.frame = "odom";
    robot.step();
    assert!(robot.has_notice("or start the node with --odom-is-map"), "{:?}", robot.notices);
    let tilted = pitched("map", "odom", &Pose::default(), 1.2);
    robot.receive(&IncomingMessage::StaticTransforms(tilted));
    robot.step();
    assert!(robot.has_notice("which tf tilts against `map`"), "{:?}", robot.notices);
}

#[test]
fn stamps_of_a_simulated_clock_are_named() {
    for (late_s, cause) in [(1e9, "use_sim_time"), (5.0, "chrony or NTP")] {
        let mut robot = Robot::new(false);
        robot.now_s += 2e9;
        (robot.odometry_late_s, robot.has_scan) = (late_s, false);
        (0..3).for_each(|_| assert_eq!(robot.step(), None));
        let found = robot.notices.iter().find(|notice| notice.contains("old when they arrive"));
        assert!(found.is_some_and(|notice| notice.contains(cause)), "{:?}", robot.notices);
    }
}
