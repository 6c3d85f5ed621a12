//! Worlds of moving cylinders, made here and driven, and one of the benchmark's.

use std::path::Path;

use inbye::experiment::dynabarn::{
    Body, Culprit, DynaBarnRow, DynaBarnWorld, Summary, Task, dynabarn_config, read_worlds,
};
use inbye::experiment::worlds::{Verdict, drive};
use inbye::geometry::{Point, Pose};
use inbye::runtime::Config;
use inbye::sim::TimedPath;
use libtest_mimic::{Completion, Failed, Trial};

use super::Test;

pub const TESTS: &[Test] = &[
    ("a cylinder that crosses is passed", passes),
    ("who does not see it drives into it", blind_drives_in),
    (
        "who is run over by what cannot be evaded is not to blame",
        run_over,
    ),
    ("contacts are counted by whose they are", counts),
];

const WORLDS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/data/dynabarn");

/// Six metres along x among these.
fn world(bodies: Vec<Body>) -> DynaBarnWorld {
    DynaBarnWorld {
        number: 7,
        start: Pose::new(3.0, 0.0, core::f64::consts::PI),
        goal: Point::new(-3.0, 0.0),
        bodies,
    }
}

/// From one place to another and, at once, again.
fn body(radius_m: f64, from: [f64; 2], to: [f64; 2], loop_s: f64) -> Body {
    scripted(radius_m, &[(0.0, from), (loop_s, to)], loop_s)
}

fn scripted(radius_m: f64, keys: &[(f64, [f64; 2])], loop_s: f64) -> Body {
    let keys: Vec<_> = keys
        .iter()
        .map(|&(time_s, place)| (time_s, Point::from(place)))
        .collect();
    let script = TimedPath::new(&keys, Some(loop_s)).expect("a sound script");
    Body { radius_m, script }
}

/// To and fro across the straight way at 0.9 m/s, on it when the robot would be there.
fn crossing() -> DynaBarnWorld {
    let keys = [(0.0, [0.0, -2.0]), (4.5, [0.0, 2.0]), (9.0, [0.0, -2.0])];
    world(vec![scripted(0.5, &keys, 9.0)])
}

fn run(world: &DynaBarnWorld, config: &Config) -> DynaBarnRow {
    let task = Task { world, seed: 0 };
    drive(&task, config, &mut || 0.0).expect("a small world").0
}

/// A Jackal that sees a hand's breadth.
fn blind() -> Config {
    let mut blind = dynabarn_config();
    blind.lidar.range_max_m = 0.1;
    blind
}

fn passes() {
    let (world, config) = (crossing(), dynabarn_config());
    let row = run(&world, &config);
    assert_eq!(
        (row.result, row.blame),
        (Verdict::Succeeded, Culprit::Nobody),
        "{row:?}"
    );
    assert!(row.min_clearance_m.is_some_and(|gap_m| gap_m > 0.05));
    // It was stopped at the first tick within a metre of the goal.
    assert!(row.travelled_m > 4.8 && row.plans > 0, "{row:?}");
    assert_eq!(row, run(&world, &config), "the same again");
}

fn blind_drives_in() {
    // One that stands in the way.
    let world = world(vec![body(0.5, [0.0, 0.1], [0.0, 0.1], 5.0)]);
    let row = run(&world, &blind());
    assert_eq!(
        (row.result, row.blame),
        (Verdict::Collided, Culprit::Robot),
        "{row:?}"
    );
    // The sibling: who sees it passes.
    let row = run(&world, &dynabarn_config());
    assert_eq!(row.result, Verdict::Succeeded, "{row:?}");
}

fn run_over() {
    // From behind, twelve metres wide and nine times as fast as the robot.
    let row = run(
        &world(vec![body(6.0, [16.0, 0.0], [-20.0, 0.0], 2.0)]),
        &dynabarn_config(),
    );
    assert_eq!(
        (row.result, row.blame),
        (Verdict::Collided, Culprit::Other),
        "{row:?}"
    );
    // The sibling: from the side, slower than the robot and seen by none, it could have been left behind.
    let mut still = blind();
    still.robot.limits.max_vel_x = 0.01;
    still.robot.limits.min_vel_x = -2.0;
    let row = run(
        &world(vec![body(0.5, [3.0, 3.0], [3.0, -6.0], 9.0)]),
        &still,
    );
    assert_eq!(
        (row.result, row.blame),
        (Verdict::Collided, Culprit::Avoidable),
        "{row:?}"
    );
}

fn counts() {
    let row = |world, result, blame| DynaBarnRow {
        world,
        seed: 0,
        result,
        blame,
        time_s: 10.0,
        travelled_m: 20.0,
        min_clearance_m: Some(0.1),
        plans: 1,
        fault: None,
        decision_p50_ms: None,
        decision_p99_ms: None,
    };
    let rows = [
        row(1, Verdict::Succeeded, Culprit::Nobody),
        row(2, Verdict::Succeeded, Culprit::Nobody),
        row(2, Verdict::Collided, Culprit::Other),
        row(3, Verdict::Collided, Culprit::Robot),
        row(4, Verdict::Collided, Culprit::Avoidable),
        row(4, Verdict::Timeout, Culprit::Nobody),
        row(5, Verdict::Failed, Culprit::Nobody),
        row(5, Verdict::Collided, Culprit::Other),
    ];
    let summary = Summary::of(&rows.iter().collect::<Vec<_>>());
    assert_eq!((summary.worlds, summary.runs, summary.succeeded), (5, 8, 2));
    assert_eq!(
        (
            summary.collided,
            summary.by_robot,
            summary.avoidable,
            summary.other
        ),
        (4, 1, 1, 2)
    );
    assert_eq!((summary.timeout, summary.failed), (1, 1));
    assert_eq!(
        (summary.success, summary.success_attributed),
        (0.25, Some(2.0 / 6.0))
    );
    let only = Summary::of(&[&rows[2]]);
    assert_eq!((only.success, only.success_attributed), (0.0, None));
    assert_eq!(Summary::of(&[]), Summary::default());
}

pub fn trial() -> Trial {
    Trial::ignorable_test("a world of the benchmark that moves is crossed", || {
        if !Path::new(WORLDS).exists() {
            return Ok(Completion::ignored_with(
                "the development data are not beside the repository",
            ));
        }
        crosses()?;
        Ok(Completion::Completed)
    })
}

fn crosses() -> Result<(), Failed> {
    let worlds = read_worlds(Path::new(WORLDS), Some(&[16]))?;
    let task = Task {
        world: &worlds[0],
        seed: 0,
    };
    let (row, _) = drive(&task, &dynabarn_config(), &mut || 0.0)?;
    assert_eq!(row.result, Verdict::Succeeded, "{row:?}");
    assert!(row.travelled_m > 18.5, "{row:?}");
    Ok(())
}
