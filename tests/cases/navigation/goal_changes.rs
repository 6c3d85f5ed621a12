//! Other goals for a robot that drives, has arrived, or has given up.

use inbye::geometry::{Point, Pose, Twist};
use inbye::local::CpuEngine;
use inbye::map::{GridFrame, ObstacleGrid, Scan};
use inbye::navigator::{Decision, Goal, Mode, Navigator, Observation, Waypoints};
use inbye::runtime::Config;

const PERIOD_S: f64 = 0.1;
const BEAMS: usize = 720;
const RANGE_M: f64 = 12.0;
/// A pillar that the map does not show: centre, and radius in metres.
const PILLAR: (Point, f64) = (Point { x: 7.0, y: 5.0 }, 0.3);

/// A robot without lag that drives by its own navigator on an empty map of 14 by 10 m.
struct Robot {
    navigator: Navigator,
    pose: Pose,
    twist: Twist,
    ticks: u32,
}

impl Robot {
    fn new(goal: Goal) -> Self {
        let frame = GridFrame::new(140, 100, 0.1, Pose::default()).expect("a small map");
        let pose = Pose::new(2.0, 5.0, 0.0);
        let waypoints = Waypoints { start: pose.position(), goals: vec![goal] };
        let (known, engine) =
            (ObstacleGrid::filled(frame, false), Box::new(CpuEngine::single_threaded()));
        let navigator = Config::default().new_navigator(known, &waypoints, engine, &mut || 0.0);
        Self { navigator: navigator.expect("a path"), pose, twist: Twist::STOP, ticks: 0 }
    }

    /// Ranges to the pillar.
    fn scan(&self) -> Scan {
        let (center, radius_m) = PILLAR;
        let to = center - self.pose.position();
        let range = |beam: usize| {
            let angle = (beam as f64) * std::f64::consts::TAU / BEAMS as f64;
            let (sin, cos) = libm::sincos(angle + self.pose.yaw);
            let (along, across) = (to.x * cos + to.y * sin, to.y * cos - to.x * sin);
            let half = radius_m * radius_m - across * across;
            let is_hit = half >= 0.0 && along > 0.0;
            (angle, if is_hit { along - half.sqrt() } else { f64::INFINITY })
        };
        Scan::from_measurements(BEAMS, RANGE_M, (0..BEAMS).map(range))
    }

    fn step(&mut self) -> Decision {
        let time_s = f64::from(self.ticks) * PERIOD_S;
        self.ticks += 1;
        let decision = self.navigator.step(&Observation {
            time_s,
            pose: self.pose,
            pose_s: time_s,
            lost: None,
            twist: self.twist,
            odometry_s: time_s,
            scan: self.scan(),
            scan_s: time_s,
            scan_changed_s: time_s,
            sent: None,
        });
        self.twist = decision.command;
        let yaw = self.pose.yaw + PERIOD_S * self.twist.angular;
        let (sin, cos) = libm::sincos(yaw);
        let moved_m = PERIOD_S * self.twist.linear;
        self.pose = Pose::new(self.pose.x + moved_m * cos, self.pose.y + moved_m * sin, yaw);
        let gap_m = (self.pose.position() - PILLAR.0).norm() - PILLAR.1;
        assert!(gap_m > 0.4, "{:?}", self.pose);
        decision
    }

    /// Drives until the navigator drives no further.
    fn finish(&mut self) -> Mode {
        (0..4000)
            .map(|_| self.step().mode)
            .find(|mode| matches!(mode, Mode::Arrived | Mode::Failed))
            .expect("the mission ends")
    }

    fn replace_goals(&mut self, goals: Vec<Goal>) -> Result<(), String> {
        let waypoints = Waypoints { start: self.pose.position(), goals };
        Config::default()
            .replace_goals(&mut self.navigator, &waypoints, &mut || 0.0)
            .map_err(|fault| fault.to_string())
    }

    fn is_at(&self, place: Point) -> bool {
        (self.pose.position() - place).norm() < 0.1
    }
}

#[test]
fn robot_drives_on_to_other_goals_around_what_it_has_seen() {
    let mut robot = Robot::new(Goal::at(Point::new(5.0, 8.0)));
    for _ in 0..15 {
        robot.step();
    }
    let [first, second] = [Point::new(11.0, 5.0), Point::new(12.0, 7.0)];
    robot
        .replace_goals(vec![Goal::at(first), Goal { position: second, yaw: Some(1.0) }])
        .expect("paths");
    let marks = robot.navigator.obstacle_model().marks().count();
    assert!(marks > 0, "the pillar is known before and after");
    let before = robot.twist.linear;
    robot.step();
    assert!(robot.twist.linear > before - 0.11, "{before}, {:?}", robot.twist);
    assert_eq!(robot.finish(), Mode::Arrived);
    assert!(robot.is_at(second) && (robot.pose.yaw - 1.0).abs() < 0.1, "{:?}", robot.pose);
    assert_eq!(robot.navigator.goals_passed(), 1);
}

#[test]
fn goals_remain_if_there_is_no_path_to_the_others() {
    let goal = Point::new(11.0, 5.0);
    let mut robot = Robot::new(Goal::at(goal));
    for _ in 0..15 {
        robot.step();
    }
    let error = robot.replace_goals(vec![Goal::at(Point::new(99.0, 5.0))]).expect_err("outside");
    assert!(error.contains("is off the map"), "{error}");
    assert_eq!(robot.navigator.fault(), None);
    assert_eq!(robot.finish(), Mode::Arrived);
    assert!(robot.is_at(goal), "{:?}", robot.pose);
}

/// The second goal is the place of the pillar, which nothing shows before the robot is there.
#[test]
fn robot_that_arrived_or_gave_up_drives_to_other_goals() {
    let mut robot = Robot::new(Goal::at(Point::new(4.0, 5.0)));
    assert_eq!(robot.finish(), Mode::Arrived);
    robot.replace_goals(vec![Goal::at(PILLAR.0)]).expect("the map shows no pillar");
    assert_eq!(robot.finish(), Mode::Failed);
    assert!(robot.navigator.fault().is_some());
    let goal = Point::new(11.0, 5.0);
    robot.replace_goals(vec![Goal::at(goal)]).expect("a path");
    assert_eq!(robot.navigator.fault(), None);
    assert_eq!(robot.finish(), Mode::Arrived);
    assert!(robot.is_at(goal), "{:?}", robot.pose);
}
