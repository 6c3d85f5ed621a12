//! The ROS 2 node without DDS: messages in, messages out, and a simulated clock.

mod action;
mod ages;
mod given_map;
mod goal_frames;
mod inputs;
mod lifecycle;
mod localization;
mod messages;
mod new_goal;
mod protection;
mod robot;
mod transport;
mod zones;

use inbye::geometry::{Pose, Twist};
use inbye::local::{CpuEngine, Engine, EngineError, Failover, GpuFailureKind};
use inbye::ros::msg::{DiagnosticStatus, TFMessage};
use inbye::ros::node::{IncomingMessage, NodeCore, NodeSettings};
use robot::{GOAL, Robot, crossings_m, goal, grid, map, transform};

#[test]
fn node_drives_to_goal_then_stays_silent() {
    let mut robot = Robot::ready();
    robot.until(600, |robot| robot.has_notice("reached the goal"));
    assert!(robot.away_m() < 0.02, "{:?}", robot.pose);
    assert!(robot.stands());
    assert_eq!(robot.paths.len(), 1);
    let path = &robot.paths[0];
    assert_eq!(path.header.frame_id, "map");
    let ends = [path.poses[0].pose, path.poses[path.poses.len() - 1].pose];
    assert_eq!((ends[0].position.x, ends[1].position.x), (2.0, GOAL.0));
    assert!(robot.markers.iter().any(|array| array.markers.len() == 3));
    // Zero velocity for a second, then silence: another may drive.
    let zeros = robot.until(100, |robot| robot.commands.last() == Some(&None));
    assert!((9..=12).contains(&zeros), "{zeros}");
    let stats = robot.core.stats();
    assert_eq!((stats.goals, stats.reached, stats.aborted), (1, 1, 0));
    assert!(stats.rejected.is_empty(), "{stats:?}");
    // It drives to the next goal.
    robot.receive(&IncomingMessage::Goal(goal(2.0, 4.0)));
    robot.until(900, |robot| robot.core.stats().reached == 2);
}

/// Nodes that follow something send the same goal again: it must not make the robot correct what parking has left.
#[test]
fn goal_where_the_robot_stands_is_reached_without_motion() {
    let mut robot = Robot::ready();
    robot.until(600, |robot| robot.has_notice("reached the goal"));
    for reached in 2..5 {
        let again = goal(GOAL.0 + 0.004 * f64::from(reached), GOAL.1 - 0.01);
        robot.receive(&IncomingMessage::Goal(again));
        let commands = robot.commands.len();
        let steps =
            robot.until(10, |robot| robot.core.stats().reached == u64::from(reached as u32));
        assert!(steps < 7, "{steps}");
        assert!(robot.commands[commands..].iter().all(|command| *command == Some(Twist::STOP)));
    }
}

#[test]
fn node_diagnostics_report_the_failure_of_a_gpu() {
    let lost = || -> Result<Box<dyn Engine>, EngineError> {
        Err(EngineError::Lost {
            adapter: "test".to_owned(),
            kind: GpuFailureKind::DeviceLost,
            message: "gone".to_owned(),
        })
    };
    let failover = Failover::new(lost(), lost, CpuEngine::single_threaded());
    let mut robot = Robot::unarmed(false);
    robot.core =
        NodeCore::new(NodeSettings::default(), Box::new(failover)).expect("valid settings");
    robot.core.operator().arm();
    let mut robot = robot.with_goal();
    robot.until(50, |robot| robot.speed() > 0.5);
    let newest = robot.diagnostics.last().expect("diagnostics");
    let status = newest.status.iter().find(|status| status.name == "inbye: engine");
    let status = status.expect("the status of the engine");
    assert_eq!(status.level, DiagnosticStatus::WARN);
    assert!(status.message.contains("gone"), "{status:?}");
    let value = |key| status.values.iter().find(|pair| pair.key == key).map(|pair| &*pair.value);
    assert_eq!(value("gpu_failures"), Some("1"));
    assert!(value("cpu_ticks").is_some_and(|ticks| ticks != "0"), "{status:?}");
}

#[test]
fn node_without_goal_publishes_nothing() {
    let mut robot = Robot::new(false);
    robot.receive(&IncomingMessage::Map(map(&grid(29))));
    assert!((0..20).all(|_| robot.step().is_none()));
    assert_eq!(robot.core.final_command(), None);
    robot.receive(&IncomingMessage::Goal(goal(GOAL.0, GOAL.1)));
    robot.step();
    assert_eq!(robot.core.final_command(), Some(Twist::STOP));
}

#[test]
fn node_waits_for_map_odometry_and_scan() {
    let mut robot = Robot::new(false);
    (robot.has_scan, robot.has_odometry) = (false, false);
    robot.publish_mount();
    robot.receive(&IncomingMessage::Goal(goal(GOAL.0, GOAL.1)));
    for missing in ["no map was received", "no odometry was received", "no scan was received"] {
        for _ in 0..5 {
            assert_eq!(robot.step(), Some(Twist::STOP), "{missing}");
        }
        let matching = robot.notices.iter().filter(|notice| notice.contains(missing));
        assert_eq!(matching.count(), 1, "{missing}: {:?}", robot.notices);
        match missing {
            "no map was received" => robot.receive(&IncomingMessage::Map(map(&grid(29)))),
            "no odometry was received" => robot.has_odometry = true,
            _ => robot.has_scan = true,
        }
    }
    robot.until(20, |robot| robot.speed() > 0.2);
}

#[test]
fn node_stops_without_scans_and_continues_with_them() {
    let mut robot = Robot::ready();
    robot.until(50, |robot| robot.speed() > 0.8);
    robot.has_scan = false;
    // 0.3 s of age, and braking from 1 m/s at 1 m/s^2.
    let steps = robot.until(50, Robot::stands);
    assert!((5..=14).contains(&steps), "{steps}");
    assert!(robot.has_notice("braking: there is no fresh scan"));
    robot.has_scan = true;
    robot.until(600, |robot| robot.has_notice("reached the goal"));
}

#[test]
fn node_aborts_goal_without_scans() {
    let mut robot = Robot::ready();
    robot.until(50, |robot| robot.speed() > 0.5);
    robot.has_scan = false;
    robot.until(100, |robot| robot.has_notice("aborted the goal: INVALID_OBSERVATION"));
    robot.until(50, |robot| robot.commands.last() == Some(&None));
    robot.has_scan = true;
    robot.receive(&IncomingMessage::Goal(goal(GOAL.0, GOAL.1)));
    robot.until(600, |robot| robot.has_notice("reached the goal"));
    assert_eq!(robot.core.stats().aborted, 1);
}

/// The navigator, which times missing scans, does not exist yet, or is not asked.
#[test]
fn node_aborts_goal_without_a_first_scan() {
    let aborted = "aborted the goal: no scan was received for 3 s";
    let mut robot = Robot::unarmed(false).with_goal();
    robot.has_scan = false;
    // Until an operator arms the robot, no time counts.
    (0..50).for_each(|_| assert_eq!(robot.step(), Some(Twist::STOP)));
    robot.core.operator().arm();
    let steps = robot.until(50, |robot| robot.has_notice(aborted));
    assert!((30..=33).contains(&steps), "{steps}");
    robot.until(50, |robot| robot.commands.last() == Some(&None));
    robot.has_scan = true;
    robot.receive(&IncomingMessage::Goal(goal(GOAL.0, GOAL.1)));
    robot.until(50, |robot| robot.speed() > 0.8);
    // The network process starts again, and the nodes have 5 s to find each other.
    robot.core.transport_lost();
    robot.has_scan = false;
    (0..50).for_each(|_| assert_eq!(robot.step(), Some(Twist::STOP)));
    robot.core.transport_restored(robot.now_s);
    let steps = robot.until(100, |robot| robot.core.stats().aborted == 2);
    assert!((78..=83).contains(&steps), "{steps}");
}

#[test]
fn node_rejects_a_control_period_that_it_would_take_for_a_pause() {
    for (period_s, is_valid) in [(0.25, true), (0.26, false), (0.3, false)] {
        let mut settings = NodeSettings::default();
        settings.config.local.control_period_s = period_s;
        let created = NodeCore::new(settings, Box::new(CpuEngine::single_threaded()));
        let error = created.err().map(|error| error.to_string());
        assert_eq!(error.is_none(), is_valid, "{period_s}: {error:?}");
        let start = format!("[local] control_period_s is {period_s}: it must be at most 0.25");
        assert!(error.is_none_or(|error| error.starts_with(&start)));
    }
}

#[test]
fn node_stops_without_odometry_and_continues_with_it() {
    let mut robot = Robot::ready();
    robot.until(50, |robot| robot.speed() > 0.8);
    robot.has_odometry = false;
    let steps = robot.until(50, Robot::stands);
    assert!((5..=14).contains(&steps), "{steps}");
    // The node never aborts because of it.
    (0..100).for_each(|_| assert_eq!(robot.step(), Some(Twist::STOP)));
    assert!(robot.has_notice("waiting: odometry is no longer received"));
    robot.has_odometry = true;
    robot.until(600, |robot| robot.has_notice("reached the goal"));
    assert!(!robot.has_notice("clock"), "{:?}", robot.notices);
}

#[test]
fn robot_starts_from_zero_after_the_node_was_suspended() {
    for pause_s in [0.5, 2.0, -3.0] {
        let mut robot = Robot::ready();
        robot.until(50, |robot| robot.speed() > 0.8);
        robot.pause(pause_s);
        assert_eq!(robot.step(), Some(Twist::STOP), "{pause_s}");
        let mut before = 0.0;
        for _ in 0..5 {
            robot.step();
            // A control period and the latency at 1 m/s^2.
            assert!(robot.speed() - before < 0.2, "{pause_s}: {before} to {}", robot.speed());
            before = robot.speed();
        }
        if pause_s > 0.0 {
            robot.until(600, |robot| robot.has_notice("reached the goal"));
        }
    }
}

#[test]
fn repeated_scan_is_rejected() {
    let mut robot = Robot::ready();
    robot.until(50, |robot| robot.speed() > 0.8);
    robot.has_scan = false;
    let scan = robot.scan();
    for _ in 0..30 {
        robot.receive(&IncomingMessage::Scan(scan.clone()));
        robot.step();
    }
    assert!(robot.stands());
    assert!(robot.has_notice("not after the stamp of the last one"));
    assert_eq!(robot.core.stats().rejected["scan"], 29);
}

#[test]
fn odometry_in_other_frame_needs_transform() {
    let place = Pose::new(0.8, -0.3, 0.6);
    let mut robot = Robot::ready();
    (robot.frame, robot.frame_at) = ("odom", place);
    (0..5).for_each(|_| assert_eq!(robot.step(), Some(Twist::STOP)));
    assert!(robot.has_notice("tf does not connect it to `map`"));
    // A transform of another frame does not help.
    let lamp = transform("map", "lamp", &place, robot.now_s);
    robot.receive(&IncomingMessage::Transforms(lamp));
    assert_eq!(robot.step(), Some(Twist::STOP));
    robot.has_transform = true;
    robot.until(600, |robot| robot.has_notice("reached the goal"));
    assert!(robot.away_m() < 0.02, "{:?}", robot.pose);
}

#[test]
fn odom_is_map_needs_no_transform() {
    let mut robot = Robot::new(true);
    robot.frame = "odom";
    robot.publish_mount();
    robot.receive(&IncomingMessage::Map(map(&grid(29))));
    robot.receive(&IncomingMessage::Goal(goal(GOAL.0, GOAL.1)));
    robot.until(600, |robot| robot.has_notice("reached the goal"));
}

#[test]
fn lidar_pose_comes_from_tf() {
    let mount = Pose::new(0.25, -0.1, 2.0);
    let mut robot = Robot::ready();
    robot.mount = mount;
    let mast = transform("base_link", "mast", &Pose::new(0.25, -0.1, 0.0), 1.0);
    let laser = transform("/mast", "/laser", &Pose::new(0.0, 0.0, 2.0), 1.0);
    let transforms = [mast.transforms, laser.transforms].concat();
    robot.receive(&IncomingMessage::StaticTransforms(TFMessage { transforms }));
    robot.until(600, |robot| robot.has_notice("reached the goal"));
}

#[test]
fn scan_from_frame_unknown_to_tf_is_rejected() {
    let mut robot = Robot::new(false);
    robot.receive(&IncomingMessage::Map(map(&grid(29))));
    robot.receive(&IncomingMessage::Goal(goal(GOAL.0, GOAL.1)));
    (0..20).for_each(|_| assert_eq!(robot.step(), Some(Twist::STOP)));
    assert!(robot.has_notice("in the frame `laser`, which tf does not connect to `base_link`"));
    assert_eq!(robot.core.stats().rejected["scan"], 20);
    robot.publish_mount();
    robot.until(600, |robot| robot.has_notice("reached the goal"));
}

#[test]
fn changed_map_causes_new_plan_without_a_stop_and_repeated_map_does_not() {
    let mut robot = Robot::ready();
    robot.until(50, |robot| robot.speed() > 0.5);
    robot.receive(&IncomingMessage::Map(map(&grid(29))));
    robot.step();
    assert_eq!(robot.paths.len(), 1);
    robot.receive(&IncomingMessage::Map(map(&grid(24))));
    let notices = robot.notices.len();
    robot.until_published(20, 2);
    assert_eq!(robot.notices.len(), notices, "a map of the same size is no notice");
    robot.until(600, |robot| robot.has_notice("reached the goal"));
    // The wall that only the map shows is avoided.
    let wall_ends_m = 15.0 * 0.2;
    let crossings = robot.paths[1..].iter().flat_map(|path| crossings_m(path, 5.0));
    let lowest_m = crossings.reduce(f64::min);
    assert!(lowest_m.is_some_and(|lowest_m| lowest_m > wall_ends_m), "{lowest_m:?}");
}

#[test]
fn map_that_changes_every_two_seconds_does_not_stop_the_robot() {
    let mut robot = Robot::ready();
    robot.until(50, |robot| robot.speed() > 0.5);
    let reached = |robot: &Robot| {
        let away_m = robot.away_m();
        assert!(robot.speed() > 0.1 || away_m < 1.0, "stops {away_m} m from the goal");
        robot.has_notice("reached the goal")
    };
    let mut maps = 0;
    while robot.away_m() > 2.5 {
        let mut changed = map(&grid(29));
        // A SLAM node learns a cell in a far corner.
        maps += 1;
        changed.data[28 * 60 + 2] = (maps % 2 * 100) as i8;
        changed.header.stamp.sec += 20 * maps;
        robot.receive(&IncomingMessage::Map(changed));
        let start_s = robot.now_s;
        robot.until_published(20, 1 + maps as usize);
        robot.until(20, |robot| reached(robot) || robot.now_s > start_s + 1.95);
    }
    robot.until(600, reached);
    assert_eq!(robot.notices.iter().filter(|it| it.contains("driving to")).count(), 1);
    assert!(maps >= 3, "{maps}");
}

#[test]
fn map_that_grows_keeps_the_robot_driving() {
    let mut robot = Robot::ready();
    robot.until(50, |robot| robot.speed() > 0.5);
    robot.receive_grown_map();
    assert!(robot.has_notice("60 by 35 cells"));
    robot.until(600, |robot| robot.has_notice("reached the goal"));
}

#[test]
fn map_with_an_obstacle_at_the_robot_does_not_let_it_through() {
    let mut robot = Robot::ready();
    robot.until(50, |robot| robot.speed() > 0.8);
    let mut blocked = map(&grid(29));
    // Everything within a metre ahead of the robot.
    let (column, row) = ((robot.pose.x / 0.2) as usize, (robot.pose.y / 0.2) as usize);
    for row in row - 5..=row + 5 {
        blocked.data[row * 60 + column + 6..row * 60 + column + 12].fill(100);
    }
    let wall_m = (column + 6) as f64 * 0.2;
    robot.receive(&IncomingMessage::Map(blocked));
    robot.until_planned(12, |robot| robot.paths.len() == 2);
    for _ in 0..30 {
        assert!(robot.pose.x < wall_m, "{:?}", robot.pose);
        robot.step();
    }
}

#[test]
fn new_goal_replaces_current_goal() {
    let mut robot = Robot::ready();
    robot.until(50, |robot| robot.speed() > 0.5);
    robot.receive(&IncomingMessage::Goal(goal(3.0, 4.5)));
    robot.until(600, |robot| robot.has_notice("reached the goal"));
    assert!(libm::hypot(robot.pose.x - 3.0, robot.pose.y - 4.5) < 0.02);
    let stats = robot.core.stats();
    assert_eq!((stats.goals, stats.reached), (2, 1));
}

#[test]
fn goal_without_path_is_aborted() {
    let mut robot = Robot::new(false);
    robot.publish_mount();
    robot.receive(&IncomingMessage::Map(map(&grid(29))));
    robot.receive(&IncomingMessage::Goal(goal(40.0, 1.5)));
    assert_eq!(robot.step(), Some(Twist::STOP));
    assert!(robot.has_notice("GOAL_OUTSIDE_MAP"), "{:?}", robot.notices);
    robot.until(30, |robot| robot.commands.last() == Some(&None));
    // The engine remains for the next goal.
    robot.receive(&IncomingMessage::Goal(goal(GOAL.0, GOAL.1)));
    robot.until(600, |robot| robot.has_notice("reached the goal"));
}

#[test]
fn goal_in_other_frame_than_later_map_is_aborted() {
    let mut robot = Robot::new(false);
    robot.receive(&IncomingMessage::Goal(goal(GOAL.0, GOAL.1)));
    let mut floor = map(&grid(29));
    floor.header.frame_id = "floor_2".into();
    robot.receive(&IncomingMessage::Map(floor));
    robot.until(30, |robot| robot.commands.last() == Some(&None));
    assert!(robot.has_notice(
        "it is in the frame `map`, whose pose in the map's frame `floor_2` is not known"
    ));
}
