//! Step pruning changes no bit, and it skips most steps.

use std::sync::Arc;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::geometry::{Point, Pose};
use crate::local::cpu::evaluator::Team;
use crate::local::cpu::lanes::MAX_LANES;
use crate::local::cpu::soa_inputs::SoaInputs;
use crate::local::cpu::step_pruning::steps_of;
use crate::local::cpu::{CpuEngine, InstructionSet};
use crate::local::{
    Axis, ClearanceField, Detail, Engine, EngineError, Normalization, Outside, Problem,
    QuantizedProblem, Sampler, SamplerInputs, Stopping, Weights, Window,
};
use crate::map::{GridFrame, MovingDisc, ObstacleGrid};
use crate::robot::{Disc, Footprint};

/// Seed of the problems.
const SEED: u64 = 53;

/// Number of problems.
const PROBLEMS: u64 = 100;

/// A random problem with many samples that start in the middle of the field; most of them stay on it.
fn dense_problem(case: u64) -> Problem {
    random_problem(case, (0.4, 0.6), 0.45)
}

/// A random problem with slow samples in one of two corners of the field.
fn corner_problem(case: u64) -> Problem {
    let start = if case.is_multiple_of(2) { (0.02, 0.1) } else { (0.9, 0.98) };
    random_problem(case, start, 0.05)
}

/// A random problem. The start lies between two fractions of the field's width and height; the samples travel at most
/// `reach` of the shorter one.
fn random_problem(case: u64, start: (f64, f64), reach: f64) -> Problem {
    let rng = &mut Pcg64Mcg::seed_from_u64(SEED ^ case.wrapping_mul(0x9E37_79B9_7F4A_7C15));
    let frame = GridFrame {
        width: rng.random_range(20..=160),
        height: rng.random_range(20..=160),
        resolution_m: [0.02, 0.05, 0.1, 0.1254][rng.random_range(0..4)],
        origin: Pose::new(
            rng.random_range(-50.0..50.0),
            rng.random_range(-50.0..50.0),
            [0.0, 0.3, -2.0][rng.random_range(0..3)],
        ),
    };
    let density = [0.0, 0.0005, 0.002, 0.01][rng.random_range(0..4)];
    let obstacles = ObstacleGrid::from_fn(frame, |_| rng.random_bool(density));
    let field = ClearanceField::new(&obstacles).expect("in range");
    let (width, height) = (f64::from(frame.width), f64::from(frame.height));
    let mut within = |least: f64, most: f64| {
        let column = rng.random_range(least..most) * width;
        let row = rng.random_range(least..most) * height;
        frame.from_cell_units(&Point::new(column, row))
    };
    let start = within(start.0, start.1);
    let (target, key_node) = (within(0.0, 1.0), within(0.0, 1.0));
    let centers: Vec<Point> = (0..case % 6).map(|_| within(-0.2, 1.2)).collect();
    let obstacles = centers.into_iter().map(|center| MovingDisc {
        x: center.x,
        y: center.y,
        radius: rng.random_range(0.05..0.5),
        vx: rng.random_range(-1.0..1.0),
        vy: rng.random_range(-1.0..1.0),
    });
    let obstacles = obstacles.collect();
    let (step_s, steps) = (0.1, rng.random_range(2..=70));
    let shorter = width.min(height) * frame.resolution_m;
    let fastest = (reach * shorter / (f64::from(steps) * step_s)).min(4.0);
    let (low, vtheta) = (rng.random_range(-0.5..0.9) * fastest, rng.random_range(-1.0..0.8));
    let window = Window {
        vx: Axis::new(low, rng.random_range(low..fastest), rng.random_range(20..=150)),
        vtheta: Axis::new(vtheta, rng.random_range(vtheta..1.2), rng.random_range(20..=70)),
    };
    let discs = (0..rng.random_range(1..=3)).map(|_| {
        // Often central: such discs do not move when the robot turns.
        let away = f64::from(rng.random_range(0..3_u8).min(1));
        Disc {
            x: away * rng.random_range(-0.4..0.4),
            y: away * rng.random_range(-0.2..0.2),
            radius: rng.random_range(0.02..0.3),
        }
    });
    let footprint = Footprint::new(discs.collect()).expect("at least one disc with a radius");
    Problem {
        field: Arc::new(field),
        obstacles,
        pose: Pose::new(start.x, start.y, rng.random_range(-3.0..3.0)),
        window,
        sampler: Sampler::Arcs,
        sampler_inputs: SamplerInputs::default(),
        braking_x: rng.random_range(0.2..3.0),
        braking_theta: rng.random_range(0.5..6.0),
        step_s,
        steps,
        footprint,
        max_clearance_m: rng.random_range(0.3..3.0),
        outside: Outside::Obstacle,
        target,
        key_node,
        weights: Weights {
            heading: rng.random_range(0.0..1.0),
            clearance: rng.random_range(0.0..1.0),
            velocity: rng.random_range(0.0..1.0),
            path: 0.15,
        },
        normalization: Normalization::Sum,
        stopping: Stopping::Clearance,
    }
}

fn quantized(problem: &Problem) -> QuantizedProblem {
    QuantizedProblem::new(problem).expect("within the ranges")
}

fn engines() -> Vec<CpuEngine> {
    let here = InstructionSet::ALL.into_iter().filter(|one| one.is_available());
    let engines = here.map(|one| CpuEngine::with_instruction_set(one, 1).expect("available"));
    engines.collect()
}

/// Groups of steps looked up for the last tile, and all of its groups, over its discs and chunks.
fn looked_up_groups(engine: &mut CpuEngine) -> Option<(usize, usize)> {
    if engine.together.pyramid.is_empty() {
        return None;
    }
    let shard = engine.together.shards[0].get_mut().expect("no thread panicked");
    let lists = &shard.scratch.pruning.selected;
    let looked_up = lists.iter().map(|list| list.as_slice().len()).sum();
    Some((looked_up, lists.len() * engine.together.inputs.groups))
}

/// Asserts that every engine's answer equals the first one's.
fn compare(engines: &mut [CpuEngine], quantized: &QuantizedProblem, name: &str) {
    let answers: Vec<_> = engines
        .iter_mut()
        .map(|engine| engine.evaluate(quantized, Detail::Samples).expect("it never fails"))
        .collect();
    for (engine, answer) in engines.iter().zip(&answers) {
        assert_eq!(answer, &answers[0], "{name}, {}", engine.name());
    }
}

/// Compares the answers of all engines to the problems. Returns the groups of steps that the last engine looked up, and
/// all of its groups, for each problem that it pruned.
fn compare_all(engines: &mut [CpuEngine], problem: fn(u64) -> Problem) -> Vec<(usize, usize)> {
    let mut pruned = Vec::new();
    for case in 0..PROBLEMS {
        compare(engines, &quantized(&problem(case)), &format!("problem {case}"));
        let last = engines.last_mut().expect("portable lanes are always available");
        pruned.extend(looked_up_groups(last));
    }
    pruned
}

#[test]
fn step_pruning_changes_no_sample_in_corners() {
    let pruned = compare_all(&mut engines(), corner_problem).len();
    assert!(pruned > PROBLEMS as usize / 3, "only {pruned} problems were pruned");
}

#[test]
fn step_pruning_changes_no_sample_of_dense_problems() {
    let mut engines = engines();
    let groups = compare_all(&mut engines, dense_problem);
    for engine in &mut engines {
        let is_with_registers =
            matches!(engine.instructions(), InstructionSet::Neon | InstructionSet::Avx512);
        let shard = engine.together.shards[0].get_mut().expect("no thread panicked");
        assert_eq!(
            shard.scratch.pruning.register_tiles.looked_up > 0,
            is_with_registers,
            "register tiles"
        );
    }
    let pruned = groups.len();
    assert!(pruned > PROBLEMS as usize / 2, "only {pruned} problems were pruned");
    let looked_up: usize = groups.iter().map(|(looked_up, _)| looked_up).sum();
    let all: usize = groups.iter().map(|(_, all)| all).sum();
    assert!(2 * looked_up < all, "{looked_up} of {all} groups were looked up");
}

/// Slow samples close together, in the middle of a large field.
fn slow_problem(steps: u32) -> Problem {
    let frame = GridFrame { width: 64, height: 64, resolution_m: 0.05, origin: Pose::default() };
    let blocked = (0..frame.len()).map(|index| index % 977 == 0).collect();
    let field = ClearanceField::new(&ObstacleGrid::new(frame, blocked)).expect("in range");
    let horizon_s = 0.1 * f64::from(steps);
    Problem {
        field: Arc::new(field),
        obstacles: Vec::new(),
        pose: Pose::new(1.6, 1.6, 0.3),
        window: Window {
            vx: Axis::new(0.0, 0.1 / horizon_s, 128),
            vtheta: Axis::new(-0.2 / horizon_s, 0.2 / horizon_s, 16),
        },
        steps,
        target: Point::new(2.5, 1.8),
        key_node: Point::new(2.0, 1.7),
        ..dense_problem(0)
    }
}

#[test]
fn step_groups_cover_every_horizon_and_end_with_the_tables() {
    let mut inputs = SoaInputs::default();
    let (mut steps, mut beyond) = (Vec::new(), 0);
    for horizon in 1..=1023 {
        let quantized = quantized(&slow_problem(horizon));
        inputs.fill(&quantized, MAX_LANES);
        let groups: Vec<i32> = (0..inputs.groups as i32).collect();
        steps_of(&inputs, &groups, &mut steps);
        let all = 0..horizon as i32;
        assert!(all.into_iter().all(|step| steps.contains(&step)), "{horizon}");
        let last = steps.iter().max().expect("at least one step");
        assert!(*last < inputs.steps as i32, "{horizon}: step {last}");
        beyond += u32::from(inputs.groups * inputs.group as usize > inputs.steps);
    }
    assert!(beyond > 0, "no last group is longer than the tables");
}

#[test]
fn last_group_longer_than_the_tables_is_clipped() {
    let quantized = quantized(&slow_problem(176));
    let mut engines = engines();
    compare(&mut engines, &quantized, "176 steps");
    let SoaInputs { groups, group, steps, .. } = engines[0].together.inputs;
    assert!(groups * group as usize > steps, "{groups} of {group}");
}

#[test]
fn tiles_of_few_lookups_are_not_pruned() {
    let mut inputs = SoaInputs::default();
    let mut is_pruned = |columns, sampler| {
        let mut problem = Problem { sampler, ..slow_problem(20) };
        problem.window.vx.count = columns;
        inputs.fill(&quantized(&problem), MAX_LANES);
        inputs.allows_pruning
    };
    // A tile has one row of two segments, and up to 16 rows of arcs.
    assert!(!is_pruned(64, Sampler::TwoSegments));
    assert!(is_pruned(80, Sampler::TwoSegments));
    assert!(is_pruned(64, Sampler::Arcs));
}

#[test]
fn bound_that_is_too_high_changes_samples() {
    let mut wrong = 0;
    for case in 0..PROBLEMS {
        let quantized = quantized(&dense_problem(case));
        let mut engine = CpuEngine::single_threaded();
        let expected = engine.evaluate(&quantized, Detail::Samples);
        engine.together.pyramid.entries.fill(u16::MAX);
        let evaluator = &mut engine.together;
        evaluator.evaluate_rows(&quantized, &mut Team::default());
        let chosen = evaluator.select(&quantized, Team::default());
        let samples = evaluator.samples(&quantized);
        let expected = expected.expect("the CPU engine never fails");
        let same =
            expected.samples.as_ref() == Some(&samples) && expected.totals == chosen.0.totals;
        wrong += u64::from(!same);
    }
    assert!(wrong > PROBLEMS / 4, "only {wrong} problems changed");
}

#[test]
fn every_visited_cell_is_in_the_reachable_region() {
    // A region that misses a cell would clip a box; an empty region would too.
    for case in 0..PROBLEMS {
        let problem = dense_problem(case);
        let field = Arc::clone(&problem.field);
        let quantized = quantized(&problem);
        let mut engine = CpuEngine::single_threaded();
        engine.evaluate(&quantized, Detail::Answer).expect("the CPU engine never fails");
        if engine.together.pyramid.is_empty() {
            continue;
        }
        let region = engine.together.pyramid.region;
        for index in 0..problem.window.len() as u32 {
            let twist = problem.window.twist(index);
            let mut pose = problem.pose;
            for _ in 0..problem.steps {
                pose.x += twist.linear * problem.step_s * libm::cos(pose.yaw);
                pose.y += twist.linear * problem.step_s * libm::sin(pose.yaw);
                pose.yaw += twist.angular * problem.step_s;
                for (center, _) in problem.footprint.at(&pose) {
                    let Some(cell) = field.frame().cell_of(&center) else {
                        continue;
                    };
                    let (column, row) = (cell.column - region.column, cell.row - region.row);
                    let inside =
                        (0..region.width).contains(&column) && (0..region.height).contains(&row);
                    assert!(inside, "problem {case}, sample {index}: {cell:?}, {region:?}");
                }
            }
        }
    }
}

#[test]
fn more_threads_than_an_engine_may_have_are_an_error() {
    let most = CpuEngine::MAX_THREADS;
    let error = CpuEngine::with_threads(most + 1).expect_err("too many");
    assert_eq!(error, EngineError::TooManyThreads { threads: most + 1, most });
    assert_eq!(error.to_string(), "1025 CPU threads: an engine has at most 1024");
}
