//! What the sieve leaves out changes no bit, and it does leave most out.

use std::sync::Arc;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::bench::random_problem;
use crate::geometry::{Point, Pose};
use crate::local::cpu::{CpuEngine, Instructions};
use crate::local::{Axis, Detail, Engine, Outside, Prepared, Problem, Stopping};

/// Seed of the problems.
const SEED: u64 = 53;

/// How many problems.
const PROBLEMS: u64 = 100;

/// A random problem with many samples, which start in the middle of the field and mostly stay on it.
fn dense_problem(case: u64) -> Problem {
    let rng = &mut Pcg64Mcg::seed_from_u64(SEED ^ case);
    let problem = random_problem(SEED, case);
    let frame = problem.field.frame();
    let middle = Point::new(f64::from(frame.width) / 2.0, f64::from(frame.height) / 2.0);
    let middle = frame.from_cell_units(&middle);
    let steps = rng.random_range(2..=70);
    let shorter = f64::from(frame.width.min(frame.height)) * frame.resolution_m;
    let fastest = (0.45 * shorter / (f64::from(steps) * problem.step_s)).min(4.0);
    let low = rng.random_range(-0.5..0.9) * fastest;
    let turn = rng.random_range(-1.0..0.8);
    let mut window = problem.window;
    window.linear = Axis {
        low,
        high: rng.random_range(low..fastest),
        count: rng.random_range(20..=150),
    };
    window.angular = Axis {
        low: turn,
        high: rng.random_range(turn..1.2),
        count: rng.random_range(20..=70),
    };
    Problem {
        pose: Pose::new(middle.x, middle.y, problem.pose.yaw),
        window,
        steps,
        stopping: Stopping::Clearance,
        outside: Outside::Obstacle,
        ..problem
    }
}

fn engines() -> Vec<CpuEngine> {
    let here = Instructions::ALL.into_iter().filter(|one| one.are_here());
    let engines = here.map(|one| CpuEngine::with_instructions(one, 1).expect("they are here"));
    engines.collect()
}

/// Steps that the last tile was looked at, and all of its steps, over its discs and chunks.
fn looked_at(engine: &mut CpuEngine) -> Option<(usize, usize)> {
    if engine.pooled.is_empty() {
        return None;
    }
    let part = engine.parts[0].get_mut().expect("nobody panicked");
    let lists = part.picked();
    let looked = lists.iter().map(Vec::len).sum();
    Some((looked, lists.len() * engine.course.every_step.len()))
}

#[test]
fn every_sample_of_dense_problems_is_as_without_the_sieve() {
    let mut engines = engines();
    let (mut looked, mut all, mut sifted) = (0, 0, 0);
    for case in 0..PROBLEMS {
        let prepared = Prepared::new(&dense_problem(case)).expect("within the ranges");
        let answers: Vec<_> = engines
            .iter_mut()
            .map(|engine| {
                engine
                    .evaluate(&prepared, Detail::Samples)
                    .expect("a CPU answers")
            })
            .collect();
        for (engine, answer) in engines.iter().zip(&answers) {
            assert_eq!(answer, &answers[0], "problem {case}, {}", engine.name());
        }
        let last = engines.last_mut().expect("portable lanes are everywhere");
        if let Some((some, whole)) = looked_at(last) {
            sifted += 1;
            looked += some;
            all += whole;
        }
    }
    assert!(sifted > PROBLEMS / 2, "only {sifted} problems were sifted");
    assert!(2 * looked < all, "{looked} of {all} steps were looked at");
}

#[test]
fn a_bound_that_is_too_high_is_noticed() {
    let mut wrong = 0;
    for case in 0..PROBLEMS {
        let prepared = Prepared::new(&dense_problem(case)).expect("within the ranges");
        let mut engine = CpuEngine::single_threaded();
        let expected = engine.evaluate(&prepared, Detail::Samples);
        engine.pooled.forget();
        engine.judge(&prepared);
        let chosen = engine.select(&prepared);
        let samples = engine.samples(&prepared);
        let expected = expected.expect("a CPU answers");
        let same =
            expected.samples.as_ref() == Some(&samples) && expected.totals == chosen.0.totals;
        wrong += u64::from(!same);
    }
    assert!(wrong > PROBLEMS / 4, "only {wrong} were noticed");
}

#[test]
fn every_cell_that_is_looked_at_is_in_the_region() {
    // A region that misses a cell would cut its box off; so would one that is empty.
    for case in 0..PROBLEMS {
        let problem = dense_problem(case);
        let field = Arc::clone(&problem.field);
        let prepared = Prepared::new(&problem).expect("within the ranges");
        let mut engine = CpuEngine::single_threaded();
        engine
            .evaluate(&prepared, Detail::Answer)
            .expect("a CPU answers");
        if engine.pooled.is_empty() {
            continue;
        }
        let region = engine.pooled.region();
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
                    assert!(
                        inside,
                        "problem {case}, sample {index}: {cell:?}, {region:?}"
                    );
                }
            }
        }
    }
}
