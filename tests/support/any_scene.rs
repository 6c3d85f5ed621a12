//! Property tests over arbitrary problems: the engine is close to the oracle, and every instruction set returns the
//! bits of the scalar reference. A failing problem is shrunk to the smallest one that still fails.

use std::sync::Arc;

use inbye::geometry::{Point, Pose, Twist};
use inbye::local::{
    Axis, ClearanceField, CpuEngine, Detail, Engine, InstructionSet, Normalization, Outside,
    Problem, QuantizedProblem, Sampler, SamplerInputs, Stopping, Weights, Window,
};
use inbye::map::{Cell, GridFrame, MovingDisc, ObstacleGrid};
use inbye::robot::{Disc, Footprint, Limits};
use proptest::collection::vec;
use proptest::prelude::{Just, Strategy, prop_oneof};
use proptest::test_runner::{Config, RngAlgorithm, TestCaseError, TestRng, TestRunner};

use super::closeness::{Worst, compare};
use super::naive::Fault;
use super::scenes::Scene;

/// Side of the field, cells.
const SIDE: i32 = 160;

/// Tests a property over the same problems in every run.
fn for_any_scene(cases: u32, property: impl Fn(Scene) -> Result<(), TestCaseError>) {
    let config = Config { cases, failure_persistence: None, ..Config::default() };
    let rng = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    let outcome = TestRunner::new_with_rng(config, rng).run(&scene(), property);
    if let Err(failure) = outcome {
        panic!("{failure}");
    }
}

fn scene() -> impl Strategy<Value = Scene> {
    (grid(), motion(), body(), judging()).prop_map(
        |(
            (resolution_m, blocked),
            (pose, window, steps, step_s, (sampler, sampler_inputs)),
            (footprint, obstacles),
            judging,
        )| {
            let frame = GridFrame {
                width: SIDE,
                height: SIDE,
                resolution_m,
                origin: Pose::new(-3.0, 5.0, 0.4),
            };
            let mut grid = ObstacleGrid::filled(frame, false);
            for cell in &blocked {
                grid.set(*cell, true);
            }
            let at = |[x, y]: [f64; 2]| {
                let side = f64::from(SIDE);
                frame.from_cell_units(&Point::new(x * side, y * side))
            };
            let start = at([pose[0], pose[1]]);
            let (max_clearance_m, weights, normalization, stopping, outside, target) = judging;
            let obstacles = obstacles.into_iter().map(|[x, y, radius, vx, vy]| {
                let center = at([x, y]);
                MovingDisc { x: center.x, y: center.y, radius, vx, vy }
            });
            let problem = Problem {
                field: Arc::new(ClearanceField::new(&grid).expect("a resolution in range")),
                pose: Pose::new(start.x, start.y, pose[2]),
                window,
                sampler,
                sampler_inputs,
                braking_x: 1.0,
                braking_theta: 2.0,
                step_s,
                steps,
                footprint,
                max_clearance_m,
                outside,
                obstacles: obstacles.collect(),
                target: at(target),
                key_node: at([target[1], target[0]]),
                weights,
                normalization,
                stopping,
            };
            Scene { problem, blocked }
        },
    )
}

/// Resolution and blocked cells, few to many.
fn grid() -> impl Strategy<Value = (f64, Vec<Cell>)> {
    let cell = (0..SIDE, 0..SIDE).prop_map(|(column, row)| Cell::new(column, row));
    (
        prop_oneof![Just(0.02), Just(0.05), Just(0.124)],
        prop_oneof![vec(cell.clone(), 0..4), vec(cell, 20..200)],
    )
}

/// Start as fractions of the field with a heading, window and horizon.
fn motion() -> impl Strategy<Value = ([f64; 3], Window, u32, f64, (Sampler, SamplerInputs))> {
    let axis = |least: f64, most: f64, width: f64, count: u32| {
        let range = (least..most, 0.0..width, 1..=count);
        range.prop_map(|(low, width, count)| Axis {
            through: [Some(0.0), Some(low + 0.4 * width)],
            ..Axis::new(low, low + width, count)
        })
    };
    let window = (axis(-0.3, 1.0, 0.8, 120), axis(-1.0, 0.9, 0.3, 20));
    let window = window.prop_map(|(linear, angular)| Window { vx: linear, vtheta: angular });
    let inputs = (-0.3..1.5, -1.0..1.0, -0.3..0.0, 0.2..1.5, 0.05..4.0, 0..100_u32);
    let inputs = inputs.prop_map(|(linear, angular, least, most, ramp_time_s, seed)| {
        let limits = Limits::default().min_vel_x(least).max_vel_x(most);
        let twist = Twist::new(linear, angular);
        SamplerInputs { twist, limits, ramp_time_s, seed, ..SamplerInputs::default() }
    });
    let sampler = proptest::sample::select(&Sampler::ALL[..]);
    let start = [0.3..0.7, 0.3..0.7, -3.1..3.1_f64];
    (start, window, 1..=60_u32, prop_oneof![Just(0.05), Just(0.1)], (sampler, inputs))
}

/// Discs of the robot; moving obstacles as fractions of the field, with radius and velocity.
fn body() -> impl Strategy<Value = (Footprint, Vec<[f64; 5]>)> {
    let disc = (-0.4..0.4, -0.3..0.3, 0.02..0.25);
    let disc = disc.prop_map(|(x, y, radius)| Disc { x, y, radius });
    let discs = vec(disc, 1..=8).prop_map(|discs| Footprint::new(discs).expect("has a disc"));
    let moving = [0.0..1.0, 0.0..1.0, 0.05..0.4, -1.5..1.5, -1.5..1.5_f64];
    (discs, vec(moving, 0..10))
}

type Judging = (f64, Weights, Normalization, Stopping, Outside, [f64; 2]);

fn judging() -> impl Strategy<Value = Judging> {
    let weights = [0.0..1.0, 0.0..1.0, 0.0..1.0, 0.0..1.0_f64];
    let weights = weights.prop_map(|[heading, clearance, velocity, path]| {
        Weights::default().heading(heading).clearance(clearance).velocity(velocity).path(path)
    });
    (
        0.2..3.0,
        weights,
        prop_oneof![Just(Normalization::Sum), Just(Normalization::MinMax)],
        prop_oneof![3 => Just(Stopping::Clearance), 1 => Just(Stopping::Arc)],
        prop_oneof![Just(Outside::Obstacle), Just(Outside::Free)],
        [0.0..1.0, 0.0..1.0_f64],
    )
}

#[test]
fn every_instruction_set_returns_the_bits_of_the_reference() {
    for_any_scene(400, |scene| {
        let problem =
            QuantizedProblem::new(&scene.problem).map_err(|error| fail(&error.to_string()))?;
        let mut expected = None;
        for instructions in InstructionSet::ALL {
            if !instructions.is_available() {
                continue;
            }
            let engine = CpuEngine::with_instruction_set(instructions, 1);
            let mut engine = engine.map_err(|error| fail(&error.to_string()))?;
            let found = engine.evaluate(&problem, Detail::Samples);
            let found = found.map_err(|error| fail(&error.to_string()))?;
            match &expected {
                None => expected = Some(found),
                Some(expected) if *expected != found => {
                    return Err(differ(expected, &found, &engine));
                }
                Some(_) => {}
            }
        }
        Ok(())
    });
}

#[test]
fn reference_is_close_to_the_oracle() {
    for_any_scene(60, |scene| {
        let mut worst = Worst::default();
        compare(&scene, "any problem", Fault::No, &mut worst);
        match worst.failures.first() {
            None => Ok(()),
            Some(failure) => Err(fail(failure)),
        }
    });
}

/// A fault in the oracle must be found, and reported with the smallest problem that shows it.
#[test]
#[should_panic(expected = "minimal failing input")]
fn oracle_with_a_fault_is_reported() {
    for_any_scene(60, |scene| {
        let mut worst = Worst::default();
        compare(&scene, "any problem", Fault::TurnsFirst, &mut worst);
        match worst.failures.first() {
            None => Ok(()),
            Some(failure) => Err(fail(failure)),
        }
    });
}

fn fail(what: &str) -> TestCaseError {
    TestCaseError::fail(what.to_owned())
}

fn differ(
    expected: &inbye::local::Evaluation,
    found: &inbye::local::Evaluation,
    engine: &CpuEngine,
) -> TestCaseError {
    let mut differences = Vec::new();
    inbye::bench::compare(expected, found, |what, expected, found| {
        differences.push(format!("{what}: {found}, not {expected}"));
    });
    let count = differences.len();
    differences.truncate(4);
    fail(&format!("{}: {count} differ: {differences:?}", engine.name()))
}
