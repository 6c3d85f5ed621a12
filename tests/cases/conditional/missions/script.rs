//! The navigator alone: scripted observations, tick by tick, and its decisions.

use core::f64::consts::{FRAC_PI_2, TAU};

use inbye::geometry::{Point, Pose, Twist, wrap_angle};
use inbye::local::CpuEngine;
use inbye::map::{MovingDisc, Scan};
use inbye::navigator::{Decision, Goal, Mode, Navigator, Observation, Waypoints};
use inbye::runtime::Config;
use inbye::sim::{Lidar, World};
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

use super::Test;
use super::driving::reach_s;
use super::ground::{Ground, hall};

pub const TESTS: &[Test] = &[
    ("navigator arrives, brakes in time and stands", arrives),
    ("local targets are the key nodes in order, the goal last", key_nodes_in_order),
    ("navigator stops before an obstacle that appears at braking distance", brakes_for_a_body),
    ("navigator stands while an obstacle touches the robot", stands_while_touched),
    ("navigator stands when walls enclose it", stops_between_walls),
    ("navigator stands after arrival", stands_after_arrival),
    ("robot reverses only where its lidar sees", reverses_only_where_it_sees),
    ("command is within the limits from a speed outside them", from_outside_the_limits),
];

/// A robot that follows every command exactly.
pub struct Script {
    pub navigator: Navigator,
    pub observation: Observation,
    config: Config,
}

/// A scan without any return.
pub fn empty_scan() -> Scan {
    Scan {
        angle_min: 0.0,
        angle_increment: TAU / 72.0,
        range_max: 10.0,
        ranges: vec![f64::INFINITY; 72],
        ..Scan::default()
    }
}

impl Script {
    pub fn new(ground: &Ground, start: Pose, goal: Point) -> Self {
        let engine = Box::new(CpuEngine::single_threaded());
        let waypoints = Waypoints { start: start.position(), goals: vec![Goal::at(goal)] };
        let mut config = Config::default();
        // The scripted scans do not show the walls of the map.
        config.navigator.features.scan_health = false;
        let navigator = config.new_navigator(ground.obstacles(), &waypoints, engine, &mut || 0.0);
        Self {
            navigator: navigator.expect("a path through the hall"),
            observation: Observation {
                time_s: 0.0,
                pose: start,
                pose_s: 0.0,
                lost: None,
                twist: Twist::STOP,
                odometry_s: 0.0,
                scan: empty_scan(),
                scan_s: 0.0,
                scan_changed_s: 0.0,
                sent: None,
            },
            config,
        }
    }

    /// Decides, checks the command, and follows it for one period.
    pub fn step(&mut self) -> Decision {
        let before = self.observation.clone();
        let decision = self.step_on(&before);
        self.assert_lawful(&before.twist, &decision.command);
        decision
    }

    /// As [`Self::step`], but decides from another observation than the true one, without the check.
    pub fn step_on(&mut self, seen: &Observation) -> Decision {
        let decision = self.navigator.step(seen);
        let period_s = self.config.local.control_period_s;
        let Observation { pose, twist, .. } = &mut self.observation;
        *twist = decision.command;
        let heading = pose.yaw + twist.angular * period_s / 2.0;
        pose.x += twist.linear * period_s * libm::cos(heading);
        pose.y += twist.linear * period_s * libm::sin(heading);
        pose.yaw = wrap_angle(pose.yaw + twist.angular * period_s);
        self.observation.time_s += period_s;
        let time_s = self.observation.time_s;
        let Observation { pose_s, odometry_s, scan_s, scan_changed_s, .. } = &mut self.observation;
        for stamp_s in [pose_s, odometry_s, scan_s, scan_changed_s] {
            *stamp_s = time_s;
        }
        decision
    }

    fn assert_lawful(&self, now: &Twist, command: &Twist) {
        let limits = &self.config.robot.limits;
        let reached = limits.reachable(now, command, reach_s(&self.config));
        assert!((reached.linear - command.linear).abs() < 1e-9, "{now:?} to {command:?}");
        assert!((reached.angular - command.angular).abs() < 1e-9, "{now:?} to {command:?}");
        self.assert_within_limits(command);
    }

    fn assert_within_limits(&self, command: &Twist) {
        let limits = &self.config.robot.limits;
        assert!((limits.min_vel_x..=limits.max_vel_x).contains(&command.linear), "{command:?}");
        assert!(command.angular.abs() <= limits.max_vel_theta, "{command:?}");
    }

    /// Steps until the mission is over, for at most this time in seconds.
    pub fn finish(&mut self, most_s: f64) -> Decision {
        loop {
            let decision = self.step();
            if matches!(decision.mode, Mode::Arrived | Mode::Failed) {
                return decision;
            }
            let now_s = self.observation.time_s;
            assert!(now_s < most_s, "not over after {now_s} s: {decision:?}");
        }
    }
}

/// A drive of 8 m straight ahead in a hall.
pub fn straight() -> Script {
    Script::new(&hall(11.0, 5.0), Pose::new(1.5, 3.0, 0.0), Point::new(9.5, 3.0))
}

fn arrives() {
    let mut script = straight();
    let mut fastest: f64 = 0.0;
    while script.observation.pose.x < 9.2 {
        fastest = fastest.max(script.step().command.linear);
        assert!(script.observation.time_s < 40.0);
    }
    assert!(fastest > 0.5, "too slow: {fastest}");
    let last = script.finish(45.0);
    assert_eq!((last.mode, last.command), (Mode::Arrived, Twist::STOP));
    let miss = (script.observation.pose.position() - Point::new(9.5, 3.0)).norm();
    let tolerance = Config::default().navigator.xy_goal_tolerance;
    assert!(miss <= tolerance && script.navigator.fault().is_none(), "{miss}");
}

fn key_nodes_in_order() {
    let ground = hall(12.0, 9.0).wall([0.0, 4.3, 9.0, 5.0]);
    let goal = Point::new(1.5, 7.5);
    let mut script = Script::new(&ground, Pose::new(1.5, 2.0, 0.0), goal);
    let path = script.navigator.plans()[0].smoothed.clone();
    let mut furthest_m = 0.0;
    let mut taken = 0;
    loop {
        let decision = script.step();
        if decision.mode == Mode::Arrived {
            assert_eq!(decision.local_target, goal);
            break;
        }
        let place = path.project(&decision.local_target);
        assert!(place.distance_m < 1e-6, "off the path: {decision:?}");
        // Where the farthest candidate is out of sight, the nearest is the target.
        let navigator = &script.config.navigator;
        let candidates_m = navigator.lookahead_m - navigator.min_lookahead_m;
        let back_m = furthest_m - place.arc_m;
        assert!(back_m < candidates_m + 1e-6, "{back_m} m back: {decision:?}");
        taken += u32::from(place.arc_m > furthest_m + 1e-6);
        furthest_m = place.arc_m.max(furthest_m);
        assert!(script.observation.time_s < 90.0, "{decision:?}");
    }
    // Half a metre apart, on a path of more than 20 m.
    assert!(taken > 20 && furthest_m == path.length_m(), "{taken} to {furthest_m}");
    assert_eq!(script.navigator.plans().len(), 1);
}

fn brakes_for_a_body() {
    let mut script = straight();
    while script.observation.pose.x < 4.5 {
        script.step();
    }
    let speed = script.observation.twist.linear;
    assert!(speed > 0.5);
    // Obstacles across the whole hall, at the braking distance and 0.3 m before the robot's nose.
    let nose = script.observation.pose.x + 0.42;
    let x = nose + speed * speed / 2.0 + 0.3 + 0.3;
    let body = |y: f64| MovingDisc { x, y, radius: 0.3, vx: 0.0, vy: 0.0 };
    let mut world = World::new(hall(11.0, 5.0).obstacles());
    world.moving = (0..9).map(|lane| body(0.8 + 0.55 * f64::from(lane))).collect();
    let lidar = Lidar::default().range_sigma_m(0.0).dropout(0.0);
    let mut noise = Pcg64Mcg::seed_from_u64(0);
    for tick in 0..60 {
        let before = script.observation.twist.linear;
        let pose = &script.observation.pose;
        script.observation.scan = lidar.scan(&world, pose, &mut noise).scan;
        let decision = script.step();
        let after = decision.command.linear;
        assert!(after <= (before - 0.05).max(0.15), "tick {tick}: {before} to {after}");
        let gap = x - 0.3 - (script.observation.pose.x + 0.42);
        assert!(gap > 0.05, "tick {tick}: {gap}");
    }
    assert!(script.observation.twist.linear < 0.1);
}

/// An obstacle that drops onto the robot's nose: the robot can only brake, and stand while they touch.
fn stands_while_touched() {
    let mut script = straight();
    while script.observation.pose.x < 4.5 {
        script.step();
    }
    assert!(script.observation.twist.linear > 0.5);
    let pose = script.observation.pose;
    let mut world = World::new(hall(11.0, 5.0).obstacles());
    // In front of its lidar, and over its foremost disc.
    world.moving = vec![MovingDisc { x: pose.x + 0.5, y: pose.y, radius: 0.3, vx: 0.0, vy: 0.0 }];
    let lidar = Lidar::default().range_sigma_m(0.0).dropout(0.0);
    let mut noise = Pcg64Mcg::seed_from_u64(0);
    for tick in 0..40 {
        // The braking robot pushes the obstacle along.
        world.moving[0].x = script.observation.pose.x + 0.5;
        script.observation.scan = lidar.scan(&world, &script.observation.pose, &mut noise).scan;
        let before = script.observation.twist;
        let after = script.step().command;
        let brakes = after.linear <= (before.linear - 0.045).max(0.0);
        assert!(brakes, "tick {tick}: {before:?} to {after:?}");
        let stands = after.linear >= 0.0 && after.angular.abs() <= before.angular.abs();
        assert!(stands, "tick {tick}: {before:?} to {after:?}");
    }
    assert_eq!(script.observation.twist, Twist::STOP);
    script.observation.scan = empty_scan();
    for _ in 0..30 {
        script.step();
    }
    assert!(script.observation.twist.linear > 0.3, "the robot drives on");
}

fn stops_between_walls() {
    let mut script = straight();
    for _ in 0..10 {
        script.step();
    }
    // Unmapped walls 0.46 m away on all sides: the corners of the robot reach 0.43 m, and it keeps a margin.
    script.observation.scan.ranges.fill(0.46);
    let mut decision = script.step();
    while script.observation.twist.linear > 0.0 {
        decision = script.step();
    }
    assert_eq!(decision.mode, Mode::Blocked);
    let stands = script.observation.pose;
    for _ in 0..100 {
        let pose = script.observation.pose;
        decision = script.step();
        let moved = (script.observation.pose.position() - pose.position()).norm();
        assert!(moved < 1e-9, "{decision:?}");
    }
    assert_eq!(script.observation.pose.position(), stands.position());
    let counts = decision.counts.expect("the window was sampled");
    assert_eq!(counts.admissible, 0);
}

fn stands_after_arrival() {
    let mut script = straight();
    script.finish(45.0);
    script.observation.pose = Pose::new(2.0, 2.0, FRAC_PI_2);
    script.observation.scan.ranges.fill(0.6);
    for _ in 0..5 {
        let decision = script.step();
        assert_eq!((decision.mode, decision.command), (Mode::Arrived, Twist::STOP));
    }
}

/// A goal behind the robot: it backs up to it, but not with a lidar that looks only ahead.
fn reverses_only_where_it_sees() {
    let slowest = |scan: Scan| {
        let ground = hall(11.0, 5.0);
        let mut script = Script::new(&ground, Pose::new(5.5, 3.0, 0.0), Point::new(5.32, 3.0));
        script.observation.scan = scan;
        let commands = (0..40).map(|_| script.step().command.linear);
        commands.fold(0.0, f64::min)
    };
    assert!(slowest(empty_scan()) < -0.05);
    let half = Scan { angle_min: -FRAC_PI_2, ranges: vec![f64::INFINITY; 37], ..empty_scan() };
    assert!(slowest(half) > -1e-9);
}

fn from_outside_the_limits() {
    for twist in [Twist::new(1.6, 0.0), Twist::new(0.5, -1.7), Twist::new(-0.9, 2.0)] {
        let mut script = straight();
        script.observation.twist = twist;
        let command = script.navigator.step(&script.observation).command;
        script.assert_within_limits(&command);
    }
}
