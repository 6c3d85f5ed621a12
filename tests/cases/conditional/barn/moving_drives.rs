//! Drives through hand-made worlds of moving cylinders, and through one world of the benchmark.

use std::path::Path;

use inbye::experiment::dynabarn::{DynaBarnWorld, ScriptedCylinder, dynabarn_config, read_worlds};
use inbye::experiment::{ContactCause, Group, RunOutcome, RunRow, World};
use inbye::geometry::{Point, Pose};
use inbye::local::CpuEngine;
use inbye::runtime::{Config, Observer};
use inbye::sim::TimedPath;
use libtest_mimic::{Failed, Trial};

use super::Test;
use crate::support::trials::with_data;

pub const TESTS: &[Test] = &[
    ("a cylinder that crosses is passed", passes),
    ("a robot that does not see a cylinder drives into it", blind_drives_in),
    ("a contact that cannot be avoided is not attributed to the robot", run_over),
    ("contacts are counted by their cause", counts),
];

/// A world with these cylinders and a course of six metres along x.
fn world(cylinders: Vec<ScriptedCylinder>) -> DynaBarnWorld {
    DynaBarnWorld {
        number: 7,
        start: Pose::new(3.0, 0.0, core::f64::consts::PI),
        goal: Point::new(-3.0, 0.0),
        cylinders,
    }
}

/// A cylinder that moves between two points and restarts at the first at once.
fn body(radius_m: f64, from: [f64; 2], to: [f64; 2], loop_s: f64) -> ScriptedCylinder {
    scripted(radius_m, &[(0.0, from), (loop_s, to)], loop_s)
}

fn scripted(radius_m: f64, keys: &[(f64, [f64; 2])], loop_s: f64) -> ScriptedCylinder {
    let keys: Vec<_> = keys.iter().map(|&(time_s, place)| (time_s, Point::from(place))).collect();
    let script = TimedPath::new(&keys, Some(loop_s)).expect("a sound script");
    ScriptedCylinder { radius_m, script }
}

/// A cylinder that moves back and forth across the straight line at 0.9 m/s and meets the robot there.
fn crossing() -> DynaBarnWorld {
    let keys = [(0.0, [0.0, -2.0]), (4.5, [0.0, 2.0]), (9.0, [0.0, -2.0])];
    world(vec![scripted(0.5, &keys, 9.0)])
}

fn run(world: &DynaBarnWorld, config: &Config) -> RunRow {
    let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut |_| {} };
    let engine = Box::new(CpuEngine::single_threaded());
    let run = World::dynabarn(world.clone()).drive(0, config, engine, &mut observer);
    run.expect("a small world").row
}

/// A Jackal that sees only a few centimetres, and drives on: nothing checks its lidar.
fn blind() -> Config {
    let mut blind = dynabarn_config();
    blind.simulation.lidar.range_max_m = 0.1;
    blind.collision_monitor.enabled = false;
    blind.navigator.features.scan_health = false;
    blind
}

fn passes() {
    let (world, config) = (crossing(), dynabarn_config());
    let row = run(&world, &config);
    assert_eq!((row.outcome, row.contact_cause), (RunOutcome::Reached, None), "{row:?}");
    assert!(row.min_clearance_m.is_some_and(|gap_m| gap_m > 0.05));
    // The run ends at the first tick within a metre of the goal.
    assert!(row.travelled_m > 4.8 && row.plans > 0, "{row:?}");
    assert_eq!(row, run(&world, &config), "the same again");
}

fn blind_drives_in() {
    // The cylinder stands in front of the robot.
    let world = world(vec![body(0.5, [0.0, 0.1], [0.0, 0.1], 5.0)]);
    let row = run(&world, &blind());
    assert_eq!(
        (row.outcome, row.contact_cause),
        (RunOutcome::Contact, Some(ContactCause::Robot)),
        "{row:?}"
    );
    // A robot that sees the cylinder passes it.
    let row = run(&world, &dynabarn_config());
    assert_eq!(row.outcome, RunOutcome::Reached, "{row:?}");
}

fn run_over() {
    // The cylinder comes from behind, 12 m wide and nine times as fast as the robot.
    let row = run(&world(vec![body(6.0, [16.0, 0.0], [-20.0, 0.0], 2.0)]), &dynabarn_config());
    assert_eq!(
        (row.outcome, row.contact_cause),
        (RunOutcome::Contact, Some(ContactCause::Other)),
        "{row:?}"
    );
    // This cylinder comes from the side and is slower than the robot. The robot does not see it, but could have left.
    let mut still = blind();
    still.robot.limits.max_vel_x = 0.01;
    still.navigator.min_approach_linear_velocity = 0.01;
    still.robot.limits.min_vel_x = -2.0;
    let row = run(&world(vec![body(0.5, [3.0, 3.0], [3.0, -6.0], 9.0)]), &still);
    assert_eq!(
        (row.outcome, row.contact_cause),
        (RunOutcome::Contact, Some(ContactCause::Avoidable)),
        "{row:?}"
    );
}

fn counts() {
    let row = |world: u32, outcome, contact_cause| RunRow {
        world: world.to_string(),
        outcome,
        contact_cause,
        time_s: 10.0,
        ..RunRow::default()
    };
    let rows = [
        row(1, RunOutcome::Reached, None),
        row(2, RunOutcome::Reached, None),
        row(2, RunOutcome::Contact, Some(ContactCause::Other)),
        row(3, RunOutcome::Contact, Some(ContactCause::Robot)),
        row(4, RunOutcome::Contact, Some(ContactCause::Avoidable)),
        row(4, RunOutcome::Timeout, None),
        row(5, RunOutcome::Failed, None),
        row(5, RunOutcome::Contact, Some(ContactCause::Other)),
    ];
    let summary = Group::of("all", &rows);
    assert_eq!((summary.worlds, summary.runs, summary.reached), (5, 8, 2));
    assert_eq!(
        (
            summary.contacts,
            summary.contacts_robot,
            summary.contacts_avoidable,
            summary.contacts_other
        ),
        (4, 1, 1, 2)
    );
    assert_eq!((summary.timeouts, summary.failed), (1, 1));
    assert_eq!((summary.reached_share, summary.attributed_share), (0.25, Some(2.0 / 6.0)));
    let only = Group::of("all", [&rows[2]]);
    assert_eq!((only.reached_share, only.attributed_share), (0.0, None));
    assert_eq!(Group::of("", []), Group::default());
}

pub fn trial() -> Trial {
    with_data("a world of the benchmark that moves is crossed", "dynabarn", crosses)
}

fn crosses(worlds: &Path) -> Result<(), Failed> {
    let worlds = read_worlds(worlds, Some(&[16]))?;
    let row = run(&worlds[0], &dynabarn_config());
    assert_eq!(row.outcome, RunOutcome::Reached, "{row:?}");
    assert!(row.travelled_m > 18.5, "{row:?}");
    Ok(())
}
