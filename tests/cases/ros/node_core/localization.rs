//! A node that localises the robot itself.

use inbye::geometry::{Pose, Twist, wrap_angle};
use inbye::ros::msg::{self, DiagnosticStatus};
use inbye::ros::node::{IncomingMessage, NodeSettings};
use inbye::runtime::PoseSource;

use super::robot::{Robot, crossings_m, goal, grid, header, map, transform};

/// The frame of the odometry in the map.
const FRAME: Pose = Pose { x: 0.8, y: -0.3, yaw: 0.6 };

/// An armed robot without a map, whose odometry has a frame of its own.
fn localizing() -> Robot {
    localizing_with(NodeSettings::default())
}

fn localizing_with(mut settings: NodeSettings) -> Robot {
    settings.config.pose_source = PoseSource::Scans;
    let mut robot = Robot::with_settings(settings);
    robot.core.operator().arm();
    (robot.frame, robot.frame_at) = ("odom", FRAME);
    robot
}

/// A hint of usual uncertainty, half a metre and 15 degrees.
fn initial_pose(frame: &str, pose: &Pose) -> IncomingMessage {
    let mut message = msg::PoseWithCovarianceStamped {
        header: header(frame, 1.0),
        ..msg::PoseWithCovarianceStamped::default()
    };
    message.pose.pose = msg::Pose::from(pose);
    let covariance = &mut message.pose.covariance;
    (covariance[0][0], covariance[1][1], covariance[5][5]) = (0.25, 0.25, 0.0685);
    IncomingMessage::InitialPose(Box::new(message))
}

/// Waits for the thread that prepares a map.
fn until_prepared(robot: &mut Robot) {
    robot.step();
    robot.until_planned(200, |robot| status(robot, "status") != "no map");
}

/// A value of the latest status of the localisation.
fn status(robot: &Robot, key: &str) -> String {
    let latest = robot.diagnostics.last().expect("diagnostics");
    let status = latest.status.iter().find(|status| status.name == "inbye: localization");
    let mut values = status.expect("a status").values.iter();
    values.find(|value| value.key == key).expect("a value").value.clone()
}

/// The largest errors of the published transforms, metres and radians.
fn largest_errors(robot: &Robot) -> (f64, f64) {
    let error = |message: &msg::TFMessage| {
        let [stamped] = message.transforms.as_slice() else {
            panic!("one transform");
        };
        assert_eq!((&*stamped.header.frame_id, &*stamped.child_frame_id), ("map", "odom"));
        let msg::Transform { translation, rotation } = stamped.transform;
        let yaw = 2.0 * libm::atan2(rotation.z, rotation.w);
        let away_m = libm::hypot(translation.x - FRAME.x, translation.y - FRAME.y);
        (away_m, wrap_angle(yaw - FRAME.yaw).abs())
    };
    let errors = robot.transforms.iter().map(error);
    errors.fold((0.0, 0.0), |most, error| (error.0.max(most.0), error.1.max(most.1)))
}

#[test]
fn robot_without_a_pose_is_found_and_drives_to_its_goal() {
    let mut robot = localizing().with_goal();
    until_prepared(&mut robot);
    assert!(robot.stands());
    robot.until(700, |robot| robot.has_notice("reached the goal"));
    assert!(robot.has_notice("the robot's pose is being searched (no pose was given"));
    assert!(robot.away_m() < 0.1, "{:?}", robot.pose);
    // The origin of the odometry's frame is metres away from the robot: an error of its yaw moves it too.
    let (error_m, error_rad) = largest_errors(&robot);
    assert!(error_m < 0.15 && error_rad < 0.03, "{error_m} {error_rad}");
    assert_eq!(status(&robot, "status"), "tracking");
}

#[test]
fn transform_is_published_only_while_the_pose_is_known() {
    let mut robot = localizing();
    robot.publish_mount();
    robot.receive(&IncomingMessage::Map(map(&grid(29))));
    // It needs no goal.
    until_prepared(&mut robot);
    robot.until(100, |robot| !robot.transforms.is_empty());
    assert_eq!(robot.commands.iter().flatten().count(), 0);
    let stamp_s = robot.transforms[0].transforms[0].header.stamp.seconds();
    assert!((stamp_s - robot.now_s).abs() < 0.011, "{stamp_s} at {}", robot.now_s);
    // The robot is carried to the other side of the wall.
    robot.pose = Pose::new(9.0, 4.5, 2.5);
    robot.frame_at = Pose::new(6.0, 2.0, 1.1);
    let known = robot.transforms.len();
    robot.until(40, |robot| status(robot, "status") == "lost");
    assert!(robot.transforms.len() - known < 40);
    robot.transforms.clear();
    robot.until(200, |robot| !robot.transforms.is_empty());
    let found = robot.transforms[0].transforms[0].transform.translation;
    assert!(libm::hypot(found.x - 6.0, found.y - 2.0) < 0.1, "{found:?}");
}

/// AMCL is left running.
#[test]
fn transform_of_another_node_is_reported_while_it_comes() {
    let mut robot = localizing();
    robot.step();
    let level = |robot: &Robot| robot.status("inbye: other nodes").0;
    assert_eq!(level(&robot), DiagnosticStatus::OK);
    for parent in ["map", "earth"] {
        let other = transform(parent, robot.frame, &Pose::default(), robot.now_s);
        robot.receive(&IncomingMessage::Transforms(other));
        robot.step();
        assert_eq!(level(&robot), DiagnosticStatus::WARN);
    }
    let notices = robot.notices.iter().filter(|notice| notice.contains("stop that localization"));
    assert_eq!(notices.count(), 1, "{:?}", robot.notices);
    robot.until(70, |robot| level(robot) == DiagnosticStatus::OK);
}

/// A map without the wall looks the same from both ends.
#[test]
fn initial_pose_decides_between_places_that_look_alike() {
    let mut robot = localizing();
    robot.publish_mount();
    let mut room = map(&grid(29));
    for row in 1..15 {
        room.data[row * 60 + 29..row * 60 + 31].fill(0);
    }
    robot.without_wall();
    robot.receive(&IncomingMessage::Map(room));
    robot.receive(&IncomingMessage::Goal(goal(9.0, 3.0)));
    until_prepared(&mut robot);
    for _ in 0..60 {
        assert_eq!(robot.step(), Some(Twist::STOP));
    }
    assert!(robot.has_notice("several places of the map match"), "{:?}", robot.notices);
    assert!(robot.transforms.is_empty());
    let rough = Pose::new(robot.pose.x + 0.4, robot.pose.y - 0.3, robot.pose.yaw + 0.3);
    robot.receive(&initial_pose("map", &rough));
    robot.until(700, |robot| robot.has_notice("reached the goal"));
    assert!(libm::hypot(robot.pose.x - 9.0, robot.pose.y - 3.0) < 0.1, "{:?}", robot.pose);
}

/// In a room that looks the same from both ends, so that only the hint decides; one in another frame does not. The second one has
/// no covariance, as that of `nav2_simple_commander`.
#[test]
fn initial_pose_before_the_map_is_used() {
    for (frame, sigma, is_used) in
        [("map", true, true), ("map", false, true), ("floor_2", true, false)]
    {
        let mut robot = localizing();
        let mut hint = initial_pose(frame, &robot.pose.clone());
        if let IncomingMessage::InitialPose(message) = &mut hint
            && !sigma
        {
            message.pose.covariance = [[0.0; 6]; 6];
        }
        robot.receive(&hint);
        robot.publish_mount();
        robot.without_wall();
        let mut room = map(&grid(29));
        for row in 1..15 {
            room.data[row * 60 + 29..row * 60 + 31].fill(0);
        }
        robot.receive(&IncomingMessage::Map(room));
        until_prepared(&mut robot);
        for _ in 0..60 {
            robot.step();
        }
        assert_eq!(status(&robot, "status") == "tracking", is_used, "{frame}");
        assert!(robot.has_notice("searching the pose near (2.00, 1.50, 0.00)"));
    }
}

#[test]
fn wrong_initial_pose_leads_to_a_search_of_the_map() {
    let mut robot = localizing().with_goal();
    until_prepared(&mut robot);
    robot.receive(&initial_pose("map", &Pose::new(9.0, 4.5, 2.0)));
    robot.until(700, |robot| robot.has_notice("reached the goal"));
    assert!(robot.away_m() < 0.1, "{:?}", robot.pose);
}

#[test]
fn robot_keeps_its_pose_on_a_map_that_grows() {
    let mut robot = localizing().with_goal();
    robot.until(900, |robot| robot.speed() > 0.5);
    robot.receive_grown_map();
    robot.until(600, |robot| robot.has_notice("reached the goal"));
    assert!(robot.away_m() < 0.1, "{:?}", robot.pose);
}

/// The passage next to the wall is blocked except for a gap at the upper border. The robot has seen this for a minute.
fn robot_that_saw_a_new_obstacle(settings: NodeSettings) -> Robot {
    let mut robot = localizing_with(settings);
    robot.publish_mount();
    robot.receive(&IncomingMessage::Map(map(&grid(29))));
    let rough = initial_pose("map", &robot.pose.clone());
    robot.receive(&rough);
    until_prepared(&mut robot);
    // From (4.8, 3.0) to (5.2, 4.4).
    robot.rebuild(24..26, 15..22, true);
    robot.until(950, |robot| !robot.updated_maps.is_empty());
    robot
}

#[test]
fn obstacle_that_is_not_on_the_map_is_reported_and_planned_around() {
    let mut robot = robot_that_saw_a_new_obstacle(NodeSettings::default());
    assert!(robot.has_notice(
        "the scans contradict the map for a minute: obstacles appeared: 1, vanished: 0"
    ));
    let updated = &robot.updated_maps[0];
    let occupied = |row: usize, column: usize| updated.data[row * 60 + column] == 100;
    let near = (15..22).filter(|row| occupied(*row, 24)).count();
    assert!(near >= 5, "{near} of 7 cells of the side that faces the robot");
    assert!(updated.header.frame_id == "map" && updated.info.resolution == 0.2);
    robot.receive(&IncomingMessage::Goal(goal(9.5, 1.5)));
    robot.until(50, |robot| !robot.paths.is_empty());
    let crossed_m = crossings_m(&robot.paths[0], 5.0);
    let [y] = crossed_m.as_slice() else {
        panic!("crosses x = 5 at {crossed_m:?}");
    };
    assert!(!(2.8..4.6).contains(y), "{y}");
    robot.until(900, |robot| robot.has_notice("reached the goal"));
}

#[test]
fn invalid_initial_poses_are_rejected() {
    let mut robot = localizing().with_goal();
    let place = robot.pose;
    robot.receive(&initial_pose("floor_2", &place));
    let IncomingMessage::InitialPose(mut message) = initial_pose("map", &place) else {
        unreachable!("an initial pose");
    };
    message.pose.covariance[5][5] = 0.0;
    robot.receive(&IncomingMessage::InitialPose(message));
    robot.receive(&initial_pose("map", &Pose::new(f64::NAN, 0.0, 0.0)));
    assert_eq!(robot.core.stats().rejected["initialpose"], 3);
    robot.step();
    for words in ["the map in `map`", "the variances of x, y and yaw", "pose.pose is not finite"] {
        assert!(robot.has_notice(words), "{words}: {:?}", robot.notices);
    }
    let mut by_transforms = Robot::ready();
    by_transforms.receive(&initial_pose("map", &place));
    by_transforms.step();
    assert!(by_transforms.has_notice("set pose_source"), "{:?}", by_transforms.notices);
}

#[test]
fn without_map_changes_an_obstacle_is_reported_and_the_map_stays() {
    let mut settings = NodeSettings::default();
    settings.config.navigator.features.map_changes = false;
    let mut robot = robot_that_saw_a_new_obstacle(settings);
    assert!(robot.has_notice("the plans do not consider that"));
    robot.receive(&IncomingMessage::Goal(goal(9.5, 1.5)));
    robot.until(50, |robot| !robot.paths.is_empty());
    let crossed_m = crossings_m(&robot.paths[0], 5.0);
    assert!(crossed_m.iter().any(|y| (2.8..4.6).contains(y)), "{crossed_m:?}");
}
