//! Messages that cannot be used: refused, counted, told once; what was known before stays.

use inbye::geometry::Pose;
use inbye::ros::msg::{LaserScan, OccupancyGrid, Odometry, PoseStamped};
use inbye::ros::node::{Arrived, Topic};

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

/// Hears a sound message, and one for each damage twice; the words of each must be in the note.
#[track_caller]
fn assert_refused<M: Clone>(sound: &M, arrived: fn(M) -> Arrived, damages: &[(Damage<M>, &str)]) {
    for (damage, words) in damages {
        let mut robot = Robot::new(false);
        let mut message = sound.clone();
        damage(&mut message);
        robot.hear(&arrived(message.clone()));
        robot.hear(&arrived(message));
        robot.hear(&arrived(sound.clone()));
        (robot.has_scan, robot.has_odometry) = (false, false);
        robot.step();
        let told: Vec<&String> = robot
            .notes
            .iter()
            .filter(|note| note.contains("is not used"))
            .collect();
        assert!(
            told.len() == 1 && told[0].contains(words),
            "{words}: {told:?}"
        );
        let tally = robot.core.tally();
        let topic = arrived(sound.clone()).topic().name();
        assert_eq!(
            (tally.refused[topic], tally.received[topic]),
            (2, 1),
            "{words}"
        );
    }
}

#[test]
fn maps() {
    let damages: [(Damage<OccupancyGrid>, &str); 9] = [
        (
            |map| map.info.width = 61,
            "it has 1800 cells, but 61 columns and 30 rows",
        ),
        (|map| map.info.width = u32::MAX, "each side must be"),
        (|map| map.info.height = 0, "each side must be"),
        (|map| map.info.resolution = f32::NAN, "resolution"),
        (|map| map.info.resolution = 0.0, "resolution"),
        (|map| map.data[7] = -2, "cell 7 is -2"),
        (
            |map| map.info.origin.orientation.w = 0.0,
            "quaternion of info.origin",
        ),
        (
            |map| map.info.origin.position.x = f64::NAN,
            "info.origin is not finite",
        ),
        (
            |map| map.header.frame_id.clear(),
            "header.frame_id is empty",
        ),
    ];
    assert_refused(&map(&grid(29)), Arrived::Map, &damages);
}

#[test]
fn scans() {
    let damages: [(Damage<LaserScan>, &str); 7] = [
        (|scan| scan.angle_min = f32::NAN, "angle_min is NaN"),
        (|scan| scan.angle_increment = 0.0, "angle_increment is 0"),
        (
            |scan| scan.angle_increment = f32::INFINITY,
            "angle_increment is inf",
        ),
        (|scan| scan.range_min = -1.0, "range_min is -1"),
        (|scan| scan.range_max = 0.0, "range_max is 0"),
        (
            |scan| scan.ranges.truncate(2),
            "it has 2 ranges, but 5 beams",
        ),
        (
            |scan| scan.angle_increment = -0.5,
            "it has 5 ranges, but -3 beams",
        ),
    ];
    assert_refused(&scan(), Arrived::Scan, &damages);
}

#[test]
fn odometry_messages() {
    let damages: [(Damage<Odometry>, &str); 7] = [
        (
            |odometry| odometry.pose.pose.position.y = f64::INFINITY,
            "pose.pose is not finite",
        ),
        (
            |odometry| odometry.pose.pose.orientation.w = 0.5,
            "length 0.5",
        ),
        (
            |odometry| {
                odometry.pose.pose.orientation.x = 1.0;
                odometry.pose.pose.orientation.w = 0.0;
            },
            "pose.pose is turned over",
        ),
        (
            |odometry| odometry.twist.twist.linear.x = f64::NAN,
            "twist.twist is not finite",
        ),
        (
            |odometry| odometry.twist.twist.angular.z = f64::NAN,
            "twist.twist is not finite",
        ),
        (
            |odometry| odometry.child_frame_id.clear(),
            "child_frame_id is empty",
        ),
        (
            |odometry| odometry.header.frame_id = "/".into(),
            "header.frame_id is empty",
        ),
    ];
    let arrived = |message| Arrived::Odometry(Box::new(message));
    assert_refused(&odometry(), arrived, &damages);
}

#[test]
fn goals() {
    let damages: [(Damage<PoseStamped>, &str); 3] = [
        (|goal| goal.pose.position.x = f64::NAN, "pose is not finite"),
        (
            |goal| goal.pose.orientation.z = 1.0,
            "quaternion of pose has length 1.41",
        ),
        (
            |goal| goal.header.frame_id.clear(),
            "header.frame_id is empty",
        ),
    ];
    assert_refused(&goal(1.0, 1.0), Arrived::Goal, &damages);
}

#[test]
fn a_goal_in_another_frame_than_the_map() {
    let mut robot = Robot::new(false);
    robot.hear(&Arrived::Map(map(&grid(29))));
    let mut lost = goal(1.0, 1.0);
    lost.header.frame_id = "odom".into();
    robot.hear(&Arrived::Goal(lost));
    assert_eq!(robot.step(), None);
    assert!(robot.has_said("it is in the frame `odom`, the map in `map`"));
}

#[test]
fn transforms_and_bytes_that_mean_nothing() {
    let mut robot = Robot::new(false);
    let mut said = transform("map", "odom", &Pose::default());
    said.transforms[0].child_frame_id.clear();
    robot.hear(&Arrived::Transforms(said));
    robot.hear(&Arrived::Undecodable(Topic::Map, "too short".into()));
    robot.step();
    assert!(robot.has_said("a message on tf is not used: its child_frame_id is empty"));
    assert!(
        robot.has_said("cannot be decoded (too short): the topic's type must be OccupancyGrid")
    );
}
