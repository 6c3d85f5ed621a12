//! Invalid messages: rejected, counted, and reported once; they change nothing.

use inbye::geometry::Pose;
use inbye::ros::msg::{
    CostmapFilterInfo, DiagnosticStatus, LaserScan, OccupancyGrid, Odometry, PoseStamped, Time,
};
use inbye::ros::node::{IncomingMessage, NodeNames, NodeSettings};

use super::robot::{Robot, goal, grid, header, map, transform};

type Damage<M> = fn(&mut M);

fn odometry() -> Odometry {
    Odometry {
        header: header("map", 1.0),
        child_frame_id: "base_link".into(),
        ..Odometry::default()
    }
}

fn scan() -> LaserScan {
    LaserScan {
        header: header("laser", 1.0),
        angle_min: -1.0,
        angle_max: 1.0,
        angle_increment: 0.5,
        range_max: 8.0,
        ranges: vec![1.0; 5],
        ..LaserScan::default()
    }
}

/// Sends each damaged message twice and then a valid one. The only notice, or that of each goal, must contain the text.
#[track_caller]
fn assert_rejected<M: Clone>(
    valid: &M,
    incoming: fn(M) -> IncomingMessage,
    damages: &[(Damage<M>, &str)],
) {
    for (damage, words) in damages {
        let mut robot = Robot::new(false);
        let mut message = valid.clone();
        damage(&mut message);
        robot.receive(&incoming(message.clone()));
        robot.receive(&incoming(message));
        robot.receive(&incoming(valid.clone()));
        (robot.has_scan, robot.has_odometry) = (false, false);
        robot.step();
        let matching: Vec<&String> =
            robot.notices.iter().filter(|notice| notice.contains("is rejected")).collect();
        let topic = incoming(valid.clone()).topic();
        let count = if topic == "goal_pose" { 2 } else { 1 };
        assert!(matching.len() == count && matching[0].contains(words), "{words}: {matching:?}");
        let stats = robot.core.stats();
        assert_eq!((stats.rejected[topic], stats.received[topic]), (2, 1), "{words}");
    }
}

#[test]
fn invalid_maps_are_rejected() {
    let damages: [(Damage<OccupancyGrid>, &str); 9] = [
        (|map| map.info.width = 61, "it has 1800 cells, but 61 columns and 30 rows"),
        (|map| map.info.width = u32::MAX, "each side must be"),
        (|map| map.info.height = 0, "each side must be"),
        (|map| map.info.resolution = f32::NAN, "resolution"),
        (|map| map.info.resolution = 0.0, "resolution"),
        (|map| map.data[7] = -2, "cell 7 is -2"),
        (|map| map.info.origin.orientation.w = 0.0, "quaternion of info.origin"),
        (|map| map.info.origin.position.x = f64::NAN, "info.origin is not finite"),
        (|map| map.header.frame_id.clear(), "header.frame_id is empty"),
    ];
    assert_rejected(&map(&grid(29)), IncomingMessage::Map, &damages);
}

#[test]
fn invalid_scans_are_rejected() {
    let damages: [(Damage<LaserScan>, &str); 13] = [
        (|scan| scan.header.frame_id.clear(), "header.frame_id is empty"),
        (|scan| scan.header.frame_id = "x".repeat(257), "at most 256 bytes"),
        (|scan| scan.header.frame_id = "\u{1b}[2J".into(), "no control characters"),
        (|scan| scan.header.stamp = Time::default(), "its stamp is zero"),
        (|scan| scan.header.stamp.sec = 200, "in the future"),
        (|scan| scan.angle_min = f32::NAN, "angle_min is NaN"),
        (|scan| scan.angle_increment = 0.0, "angle_increment is 0"),
        (|scan| scan.angle_increment = f32::INFINITY, "angle_increment is inf"),
        (|scan| scan.range_min = -1.0, "range_min is -1"),
        (|scan| scan.range_max = 0.0, "range_max is 0"),
        (|scan| scan.ranges.truncate(2), "it has 2 ranges, but 5 beams"),
        (|scan| scan.angle_increment = -0.5, "it has 5 ranges, but -3 beams"),
        (
            |scan| (scan.angle_min, scan.angle_max, scan.angle_increment) = (-180.0, 180.0, 90.0),
            "the beams span 57.3 turns: angles are in radians",
        ),
    ];
    assert_rejected(&scan(), IncomingMessage::Scan, &damages);
}

#[test]
fn invalid_odometry_is_rejected() {
    let damages: [(Damage<Odometry>, &str); 11] = [
        (|odometry| odometry.pose.pose.position.y = f64::INFINITY, "pose.pose is not finite"),
        (|odometry| odometry.pose.pose.orientation.w = 0.5, "length 0.5"),
        (
            |odometry| {
                odometry.pose.pose.orientation.x = 1.0;
                odometry.pose.pose.orientation.w = 0.0;
            },
            "pose.pose is tilted",
        ),
        (|odometry| odometry.twist.twist.linear.x = f64::NAN, "twist.twist is not finite"),
        (|odometry| odometry.twist.twist.angular.z = f64::NAN, "twist.twist is not finite"),
        (|odometry| odometry.twist.twist.linear.x = 1e300, "twist.twist is above 100 m/s"),
        (|odometry| odometry.twist.twist.angular.z = -101.0, "twist.twist is above 100 m/s"),
        (|odometry| odometry.header.stamp = Time::default(), "its stamp is zero"),
        (|odometry| odometry.header.stamp.sec = 200, "in the future"),
        (|odometry| odometry.child_frame_id.clear(), "child_frame_id is empty"),
        (|odometry| odometry.header.frame_id = "/".into(), "header.frame_id is empty"),
    ];
    let incoming = |message| IncomingMessage::Odometry(Box::new(message));
    assert_rejected(&odometry(), incoming, &damages);
}

#[test]
fn invalid_goals_are_rejected() {
    let damages: [(Damage<PoseStamped>, &str); 3] = [
        (|goal| goal.pose.position.x = f64::NAN, "pose is not finite"),
        (|goal| goal.pose.orientation.z = 1.0, "quaternion of pose has length 1.41"),
        (|goal| goal.header.frame_id.clear(), "header.frame_id is empty"),
    ];
    assert_rejected(&goal(1.0, 1.0), IncomingMessage::Goal, &damages);
}

#[test]
fn invalid_transforms_and_undecodable_bytes_are_rejected() {
    let mut robot = Robot::new(false);
    let mut message = transform("map", "odom", &Pose::default(), 1.0);
    message.transforms[0].child_frame_id.clear();
    robot.receive(&IncomingMessage::Transforms(message));
    let (topic, expected) = ("map", "OccupancyGrid");
    robot.receive(&IncomingMessage::Undecodable { topic, expected, reason: "too short".into() });
    robot.step();
    assert!(robot.has_notice("a message on tf is rejected: its child_frame_id is empty"));
    assert!(
        robot.has_notice("cannot be decoded (too short): the topic's type must be OccupancyGrid")
    );
}

#[test]
fn other_publishers_are_reported_once_and_a_warning_while_they_are_there() {
    const OTHERS: &str = "inbye: other nodes";
    let mut robot = Robot::new(false);
    robot.step();
    assert_eq!(robot.status(OTHERS).0, DiagnosticStatus::OK);
    for is_present in [true, false, true] {
        for topic in ["cmd_vel", "navigate_to_pose"] {
            robot.receive(&IncomingMessage::OtherPublisher { topic, is_present });
        }
        robot.step();
        let (level, message) = robot.status(OTHERS);
        assert_eq!(level == DiagnosticStatus::WARN, is_present, "{message}");
        assert_eq!(message.contains("twist_mux"), is_present, "{message}");
        assert_eq!(message.contains("both pursue each goal"), is_present, "{message}");
    }
    let notices = robot.notices.iter().filter(|notice| notice.contains("another node"));
    assert_eq!(notices.count(), 1, "{:?}", robot.notices);
    // A new network process finds them again.
    robot.core.transport_lost();
    robot.step();
    assert_eq!(robot.status(OTHERS).0, DiagnosticStatus::OK);
    assert!(!robot.core.stats().received.contains_key("cmd_vel"));
}

#[test]
fn other_types_are_reported_once_and_a_warning_while_they_are_there() {
    const OTHERS: &str = "inbye: other nodes";
    let mut robot = Robot::new(false);
    robot.step();
    let (twist, stamped) = ("geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped");
    for (expected, found, words) in [
        (
            twist,
            Some(stamped),
            "reads cmd_vel as geometry_msgs/msg/TwistStamped, but this node publishes geometry_msgs/msg/Twist",
        ),
        (twist, None, ""),
        (twist, Some(stamped), "start this node with --stamped"),
        (stamped, Some(twist), "start this node without --stamped"),
    ] {
        let (expected, found) = (expected.to_owned(), found.map(str::to_owned));
        let is_present = found.is_some();
        robot.receive(&IncomingMessage::OtherType { topic: "cmd_vel", expected, found });
        robot.step();
        // A change of the text alone comes with the next of them.
        (0..10).for_each(|_| assert_eq!(robot.step(), None));
        let (level, message) = robot.status(OTHERS);
        assert_eq!(level == DiagnosticStatus::WARN, is_present, "{message}");
        assert!(message.contains(words), "{message}");
    }
    let notices = robot.notices.iter().filter(|notice| notice.contains("another node"));
    assert_eq!(notices.count(), 1, "{:?}", robot.notices);
    let expected = "sensor_msgs/msg/LaserScan".to_owned();
    let found = Some("sensor_msgs/msg/PointCloud2".to_owned());
    robot.receive(&IncomingMessage::OtherType { topic: "scan", expected, found });
    robot.step();
    assert!(robot.has_notice("another node publishes scan as sensor_msgs/msg/PointCloud2"));
    assert!(!robot.core.stats().received.contains_key("cmd_vel"));
    // A new network process finds them again.
    robot.core.transport_lost();
    robot.step();
    assert_eq!(robot.status(OTHERS).0, DiagnosticStatus::OK);
}

#[test]
fn texts_have_the_remapped_names() {
    let rules = ["scan:=/front/scan", "cmd_vel:=cmd_vel_nav", "speed_filter_mask:=/zones/speed"];
    let mut settings = NodeSettings::default();
    settings.names = NodeNames::new("/rover", &rules.map(str::to_owned)).expect("valid rules");
    let mut robot = Robot::with_settings(settings);
    robot.receive(&IncomingMessage::Map(map(&grid(29))));
    let mut broken = scan();
    broken.range_max = 0.0;
    robot.receive(&IncomingMessage::Scan(broken));
    let mut invalid = odometry();
    invalid.child_frame_id.clear();
    robot.receive(&IncomingMessage::Odometry(Box::new(invalid)));
    robot.receive(&IncomingMessage::OtherPublisher { topic: "cmd_vel", is_present: true });
    let reliable = "reliable".to_owned();
    robot.receive(&IncomingMessage::Unmatched { topic: "scan", expected: reliable });
    robot.receive(&IncomingMessage::SpeedMask(map(&grid(24))));
    let mut info = CostmapFilterInfo { r#type: 1, ..CostmapFilterInfo::default() };
    for (mask, is_used) in [("/rover/speed_filter_mask", false), ("/zones/speed", true)] {
        info.filter_mask_topic = mask.to_owned();
        robot.receive(&IncomingMessage::FilterInfo(info.clone()));
        let received = robot.core.stats().received.get("costmap_filter_info").copied();
        assert_eq!(received, is_used.then_some(1));
    }
    robot.step();
    for words in [
        "a message on /front/scan is rejected",
        "a message on odom is rejected",
        "another node publishes on /rover/cmd_vel_nav too",
        "a publisher on /front/scan has another quality of service",
        "the node reads `/zones/speed`",
    ] {
        assert!(robot.has_notice(words), "{words}: {:?}", robot.notices);
    }
}

/// Of a publisher whose messages do not arrive, nothing is counted.
#[test]
fn publisher_with_another_quality_of_service_is_reported_once() {
    let mut robot = Robot::new(false);
    let expected = "reliable and transient local (latched)".to_owned();
    let unmatched = IncomingMessage::Unmatched { topic: "map", expected };
    (0..3).for_each(|_| robot.receive(&unmatched));
    robot.step();
    let found = robot.notices.iter().filter(|notice| notice.contains("a publisher on map has"));
    assert_eq!(found.count(), 1, "{:?}", robot.notices);
    assert!(robot.has_notice("publish as reliable and transient local (latched)"));
    assert!(!robot.core.stats().rejected.contains_key("map"));
}
