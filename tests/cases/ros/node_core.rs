//! The ROS 2 node without DDS: messages in, messages out, and a clock that the tests turn.

mod messages;
mod robot;

use inbye::geometry::{Pose, Twist};
use inbye::ros::msg::TFMessage;
use inbye::ros::node::Arrived;
use robot::{GOAL, Robot, goal, grid, map, transform};

#[test]
fn the_robot_drives_to_its_goal_and_leaves_the_wheel() {
    let mut robot = Robot::ready();
    robot.until(600, |robot| robot.has_said("reached the goal"));
    assert!(robot.away_m() < 0.02, "{:?}", robot.pose);
    assert!(robot.stands());
    assert_eq!(robot.paths.len(), 1);
    let path = &robot.paths[0];
    assert_eq!(path.header.frame_id, "map");
    let ends = [path.poses[0].pose, path.poses[path.poses.len() - 1].pose];
    assert_eq!((ends[0].position.x, ends[1].position.x), (2.0, GOAL.0));
    assert!(robot.markers.iter().any(|array| array.markers.len() == 3));
    // Zeros for a second, and silence: another may drive.
    let zeros = robot.until(100, |robot| robot.commands.last() == Some(&None));
    assert!((9..=12).contains(&zeros), "{zeros}");
    let tally = robot.core.tally();
    assert_eq!((tally.goals, tally.reached, tally.given_up), (1, 1, 0));
    assert!(tally.refused.is_empty(), "{tally:?}");
    // And to the next.
    robot.hear(&Arrived::Goal(goal(2.0, 4.0)));
    robot.until(900, |robot| robot.core.tally().reached == 2);
}

#[test]
fn without_a_goal_nothing_is_published() {
    let mut robot = Robot::new(false);
    robot.hear(&Arrived::Map(map(&grid(29))));
    assert!((0..20).all(|_| robot.step().is_none()));
    assert_eq!(robot.core.farewell(), None);
    robot.hear(&Arrived::Goal(goal(GOAL.0, GOAL.1)));
    robot.step();
    assert_eq!(robot.core.farewell(), Some(Twist::STOP));
}

#[test]
fn a_robot_with_a_goal_stands_until_everything_is_there() {
    let mut robot = Robot::new(false);
    (robot.has_scan, robot.has_odometry) = (false, false);
    robot.hear(&Arrived::Goal(goal(GOAL.0, GOAL.1)));
    for missing in [
        "no map has come",
        "no odometry has come",
        "no scan has come",
    ] {
        for _ in 0..5 {
            assert_eq!(robot.step(), Some(Twist::STOP), "{missing}");
        }
        let told = robot.notes.iter().filter(|note| note.contains(missing));
        assert_eq!(told.count(), 1, "{missing}: {:?}", robot.notes);
        match missing {
            "no map has come" => robot.hear(&Arrived::Map(map(&grid(29)))),
            "no odometry has come" => robot.has_odometry = true,
            _ => robot.has_scan = true,
        }
    }
    robot.until(20, |robot| robot.speed() > 0.2);
}

#[test]
fn a_stale_scan_stops_the_robot_until_scans_return() {
    let mut robot = Robot::ready();
    robot.until(50, |robot| robot.speed() > 0.8);
    robot.has_scan = false;
    // 0.3 s of age, and a metre per second at 1 m/s^2.
    let steps = robot.until(50, Robot::stands);
    assert!((5..=14).contains(&steps), "{steps}");
    assert!(robot.has_said("brakes: there is no fresh scan"));
    robot.has_scan = true;
    robot.until(600, |robot| robot.has_said("reached the goal"));
}

#[test]
fn scans_that_stay_away_end_the_goal() {
    let mut robot = Robot::ready();
    robot.until(50, |robot| robot.speed() > 0.5);
    robot.has_scan = false;
    robot.until(100, |robot| {
        robot.has_said("gave the goal up: INVALID_OBSERVATION")
    });
    robot.until(50, |robot| robot.commands.last() == Some(&None));
    robot.has_scan = true;
    robot.hear(&Arrived::Goal(goal(GOAL.0, GOAL.1)));
    robot.until(600, |robot| robot.has_said("reached the goal"));
    assert_eq!(robot.core.tally().given_up, 1);
}

#[test]
fn odometry_that_stops_stops_the_robot_until_it_returns() {
    let mut robot = Robot::ready();
    robot.until(50, |robot| robot.speed() > 0.8);
    robot.has_odometry = false;
    let steps = robot.until(50, Robot::stands);
    assert!((5..=14).contains(&steps), "{steps}");
    // However long that takes.
    (0..100).for_each(|_| assert_eq!(robot.step(), Some(Twist::STOP)));
    assert!(robot.has_said("stands: odometry has stopped coming"));
    robot.has_odometry = true;
    robot.until(600, |robot| robot.has_said("reached the goal"));
    assert!(!robot.has_said("clock"), "{:?}", robot.notes);
}

#[test]
fn a_scan_sent_again_is_an_old_one() {
    let mut robot = Robot::ready();
    robot.until(50, |robot| robot.speed() > 0.8);
    robot.has_scan = false;
    let scan = {
        let mut scan = inbye::ros::msg::LaserScan {
            angle_max: 1.0,
            angle_increment: 1.0,
            range_max: 5.0,
            ranges: vec![f32::INFINITY; 2],
            ..Default::default()
        };
        scan.header.stamp = robot::header("", robot.now_s).stamp;
        scan
    };
    for _ in 0..30 {
        robot.hear(&Arrived::Scan(scan.clone()));
        robot.step();
    }
    assert!(robot.stands());
    assert!(robot.has_said("says nothing new"));
    assert_eq!(robot.core.tally().refused["scan"], 29);
}

#[test]
fn odometry_of_another_frame_needs_a_transform() {
    let place = Pose::new(0.8, -0.3, 0.6);
    let mut robot = Robot::ready();
    (robot.frame, robot.frame_at) = ("odom", place);
    (0..5).for_each(|_| assert_eq!(robot.step(), Some(Twist::STOP)));
    assert!(robot.has_said("nothing on tf says where that lies in `map`"));
    // Not the one that is asked for.
    robot.hear(&Arrived::Transforms(transform("map", "lamp", &place)));
    assert_eq!(robot.step(), Some(Twist::STOP));
    robot.hear(&Arrived::Transforms(transform("/map", "/odom", &place)));
    robot.until(600, |robot| robot.has_said("reached the goal"));
    assert!(robot.away_m() < 0.02, "{:?}", robot.pose);
}

#[test]
fn odometry_of_another_frame_can_be_taken_as_it_is() {
    let mut robot = Robot::new(true);
    robot.frame = "odom";
    robot.hear(&Arrived::Map(map(&grid(29))));
    robot.hear(&Arrived::Goal(goal(GOAL.0, GOAL.1)));
    robot.until(600, |robot| robot.has_said("reached the goal"));
}

#[test]
fn a_lidar_off_the_origin_is_looked_up() {
    let mount = Pose::new(0.25, -0.1, 2.0);
    let mut robot = Robot::ready();
    robot.mount = mount;
    let mast = transform("base_link", "mast", &Pose::new(0.25, -0.1, 0.0));
    let laser = transform("mast", "laser", &Pose::new(0.0, 0.0, 2.0));
    let transforms = [mast.transforms, laser.transforms].concat();
    robot.hear(&Arrived::StaticTransforms(TFMessage { transforms }));
    robot.until(600, |robot| robot.has_said("reached the goal"));
    assert!(!robot.has_said("where the lidar is"));
    // Taken as at the origin, the walls that it sees stand askew in its way.
    let mut wrong = Robot::ready();
    wrong.mount = mount;
    wrong.step();
    assert!(wrong.has_said("nothing on tf says where the lidar is"));
}

#[test]
fn another_map_is_planned_on_anew_and_the_same_is_not() {
    let mut robot = Robot::ready();
    robot.until(50, |robot| robot.speed() > 0.5);
    robot.hear(&Arrived::Map(map(&grid(29))));
    robot.step();
    assert_eq!(robot.paths.len(), 1);
    robot.hear(&Arrived::Map(map(&grid(24))));
    let told = robot.notes.len();
    robot.step();
    assert!(!robot.stands() && robot.paths.len() == 1, "it stops first");
    robot.until(20, |robot| robot.paths.len() == 2);
    assert!(robot.notes[told].contains("has a map"), "{:?}", robot.notes);
    robot.until(600, |robot| robot.has_said("reached the goal"));
}

#[test]
fn another_goal_on_the_way_takes_the_place_of_the_first() {
    let mut robot = Robot::ready();
    robot.until(50, |robot| robot.speed() > 0.5);
    robot.hear(&Arrived::Goal(goal(3.0, 4.5)));
    robot.until(600, |robot| robot.has_said("reached the goal"));
    assert!(libm::hypot(robot.pose.x - 3.0, robot.pose.y - 4.5) < 0.02);
    let tally = robot.core.tally();
    assert_eq!((tally.goals, tally.reached), (2, 1));
}

#[test]
fn a_goal_that_no_path_leads_to_is_given_up() {
    let mut robot = Robot::new(false);
    robot.hear(&Arrived::Map(map(&grid(29))));
    robot.hear(&Arrived::Goal(goal(40.0, 1.5)));
    assert_eq!(robot.step(), Some(Twist::STOP));
    assert!(robot.has_said("GOAL_OUTSIDE_MAP"), "{:?}", robot.notes);
    robot.until(30, |robot| robot.commands.last() == Some(&None));
    // The engine is still there for the next.
    robot.hear(&Arrived::Goal(goal(GOAL.0, GOAL.1)));
    robot.until(600, |robot| robot.has_said("reached the goal"));
}

#[test]
fn a_goal_that_came_before_a_map_of_another_frame_is_given_up() {
    let mut robot = Robot::new(false);
    robot.hear(&Arrived::Goal(goal(GOAL.0, GOAL.1)));
    let mut floor = map(&grid(29));
    floor.header.frame_id = "floor_2".into();
    robot.hear(&Arrived::Map(floor));
    robot.until(30, |robot| robot.commands.last() == Some(&None));
    assert!(robot.has_said("it is in the frame `map`, the map in `floor_2`"));
}
