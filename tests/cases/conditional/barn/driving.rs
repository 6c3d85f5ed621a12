//! Drives through hand-made BARN worlds.

use inbye::experiment::barn::{BarnWorld, Course, Cylinder, barn_config};
use inbye::experiment::{RunOutcome, RunRow, World};
use inbye::geometry::{Point, Pose};
use inbye::local::CpuEngine;
use inbye::runtime::{Config, Observer};

use super::Test;

pub const TESTS: &[Test] = &[
    ("a few cylinders are passed", passes),
    ("a run ends within one metre of the goal", ends_within_a_metre),
    ("a robot that drives through a cylinder ends in contact", drives_through),
    ("an enclosed robot fails with a reason", walled_in),
    ("a short time limit ends in a timeout", no_time),
];

/// A shorter course than BARN's, to keep the tests fast.
const SHORT: Course = Course {
    start: Pose::new(0.0, 0.0, 0.0),
    goal: Point::new(4.0, 0.0),
    goal_radius_m: 1.0,
    time_limit_s: 30.0,
};

fn post(x_m: f64, y_m: f64) -> Cylinder {
    let radius_m = 0.075;
    Cylinder { x_m, y_m, radius_m }
}

fn run(cylinders: Vec<Cylinder>, course: Course, config: &Config) -> RunRow {
    let world = BarnWorld {
        number: 1,
        cylinders,
        course,
        optimal_time_s: 2.0,
        official: false,
        published: None,
    };
    let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut |_| {} };
    let engine = Box::new(CpuEngine::single_threaded());
    let world = World::barn(world, 2.0);
    let run = world.drive(0, config, engine, &mut observer);
    run.expect("a small world").row
}

/// Posts on the straight line to the goal.
fn posts() -> Vec<Cylinder> {
    vec![post(2.0, 0.0), post(2.0, 0.15), post(1.2, -1.0), post(2.6, 1.2)]
}

fn passes() {
    let row = run(posts(), SHORT, &barn_config(2.0));
    assert_eq!(row.outcome, RunOutcome::Reached, "{row:?}");
    assert!(row.score >= Some(0.125) && row.fault.is_none(), "{row:?}");
    assert!(row.min_clearance_m.is_some_and(|gap_m| gap_m > 0.0), "{row:?}");
    assert_eq!(row, run(posts(), SHORT, &barn_config(2.0)), "the same again");
}

fn ends_within_a_metre() {
    let row = run(posts(), SHORT, &barn_config(2.0));
    // The run ends at the first tick within the radius, so the robot is not much nearer.
    assert!((2.9..3.6).contains(&row.travelled_m), "{row:?}");
    let near = Course { goal: Point::new(0.9, 0.0), ..SHORT };
    let row = run(Vec::from([post(2.0, 0.0)]), near, &barn_config(2.0));
    assert_eq!((row.outcome, row.time_s), (RunOutcome::Reached, 0.0), "{row:?}");
}

/// A robot that sees only a few centimetres, too little to stop in time, and drives on: nothing checks its lidar.
fn blind(max_vel_x: f64) -> Config {
    let mut blind = barn_config(max_vel_x);
    blind.simulation.lidar.range_max_m = 0.1;
    blind.collision_monitor.enabled = false;
    blind.navigator.features.scan_health = false;
    blind
}

fn drives_through() {
    let row = run(posts(), SHORT, &blind(2.0));
    assert_eq!((row.outcome, row.score), (RunOutcome::Contact, Some(0.0)), "{row:?}");
    assert!(row.min_clearance_m.is_some_and(|gap_m| gap_m <= 0.0), "{row:?}");
    // Contact within the goal's radius counts as contact.
    let behind = vec![post(3.2, 0.0)];
    let tight = Course { goal_radius_m: 0.5, ..SHORT };
    assert_eq!(run(behind, tight, &blind(0.5)).outcome, RunOutcome::Contact);
}

/// A ring of posts that touch.
fn ring(radius_m: f64) -> Vec<Cylinder> {
    let count = (radius_m * 2.0 * core::f64::consts::PI / 0.14).ceil();
    let on_ring = |place: i32| {
        let angle = f64::from(place) / count * 2.0 * core::f64::consts::PI;
        let (sin, cos) = libm::sincos(angle);
        post(radius_m * cos, radius_m * sin)
    };
    (0..count as i32).map(on_ring).collect()
}

fn walled_in() {
    let mut config = barn_config(2.0);
    config.navigator.movement_time_allowance = 5.0;
    let row = run(ring(1.5), SHORT, &config);
    assert_eq!((row.outcome, row.score), (RunOutcome::Failed, Some(0.0)), "{row:?}");
    let fault = row.fault.expect("a reason");
    assert!(!fault.is_empty(), "{fault}");
}

fn no_time() {
    let short = Course { time_limit_s: 1.0, ..SHORT };
    let row = run(posts(), short, &barn_config(0.5));
    assert_eq!((row.outcome, row.score, row.fault), (RunOutcome::Timeout, Some(0.0), None));
}
