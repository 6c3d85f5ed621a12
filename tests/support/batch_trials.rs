//! Batches on each adapter: many problems in one submission return the bits of the CPU engine, one at a time.

use std::sync::Arc;

use inbye::bench::{compare, random_problem};
use inbye::geometry::Pose;
use inbye::local::{Adapter, GpuEngine};
use inbye::local::{
    Axis, CpuEngine, Detail, Engine, EngineError, Evaluation, Problem, QuantizedProblem, Window,
};
use libtest_mimic::Failed;

use super::extremes::{extremes, field, footprint, plain};

/// Random problems; every third robot has the pose and the world of the one before it.
fn problems(seed: u64, count: u64) -> Result<Vec<QuantizedProblem>, Failed> {
    let mut problems = Vec::new();
    let mut neighbour = random_problem(seed, 0);
    for case in 0..count {
        let own = random_problem(seed, case);
        let beside = Problem {
            field: Arc::clone(&neighbour.field),
            pose: neighbour.pose,
            target: neighbour.target,
            key_node: neighbour.key_node,
            ..own.clone()
        };
        // The window may be too wide for that world.
        let shared = (case % 3 == 2).then(|| QuantizedProblem::new(&beside).ok());
        problems.push(match shared.flatten() {
            Some(shared) => shared,
            None => QuantizedProblem::new(&own)?,
        });
        neighbour = own;
    }
    Ok(problems)
}

/// The answers of the CPU engine, one at a time.
fn expected(problems: &[QuantizedProblem], detail: Detail) -> Result<Vec<Evaluation>, Failed> {
    let mut engine = CpuEngine::single_threaded();
    let one = |problem| Ok(engine.evaluate(problem, detail)?);
    problems.iter().map(one).collect()
}

/// Describes how the answers to a batch differ from the expected ones.
fn differences(expected: &[Evaluation], found: &[Evaluation]) -> Option<String> {
    if expected.len() != found.len() {
        return Some(format!("{} answers, not {}", found.len(), expected.len()));
    }
    let mut first = None;
    for (index, (expected, found)) in expected.iter().zip(found).enumerate() {
        compare(expected, found, |what, expected, found| {
            first.get_or_insert(format!("problem {index}, {what}: {found}, not {expected}"));
        });
        // Checks the comparison against equality.
        if expected != found {
            first.get_or_insert(format!("problem {index}: unequal, yet nothing differs"));
        }
    }
    first
}

/// Evaluates a batch with and without samples, on an engine with earlier answers.
fn same(engine: &mut dyn Engine, name: &str, problems: &[QuantizedProblem]) -> Result<(), Failed> {
    for detail in [Detail::Samples, Detail::Answer] {
        let found = engine.evaluate_batch(problems, detail)?;
        if let Some(difference) = differences(&expected(problems, detail)?, &found) {
            let count = problems.len();
            return Err(format!("{name}, batch of {count}, {detail:?}: {difference}").into());
        }
    }
    Ok(())
}

/// Batches of random problems, each given by its first problem and its length.
pub fn random_batches(
    engine: &mut dyn Engine,
    seed: u64,
    batches: &[(usize, usize)],
) -> Result<(), Failed> {
    let ends = batches.iter().map(|(first, count)| first + count);
    let problems = problems(seed, ends.max().unwrap_or_default() as u64)?;
    for &(first, count) in batches {
        let what = format!("from problem {first}");
        same(engine, &what, &problems[first..first + count])?;
    }
    Ok(())
}

/// Batches that grow and shrink; the longest needs several submissions.
pub fn growth(adapter: &Adapter) -> Result<(), Failed> {
    let batches = [(0, 1), (1, 2), (3, 7), (10, 64), (74, 1), (75, 0), (75, 7), (0, 300), (82, 2)];
    random_batches(&mut GpuEngine::new(adapter)?, 44, &batches)
}

/// Five submissions in one call, each written while the one before it runs; every robot stands somewhere else.
pub fn many_submissions(adapter: &Adapter) -> Result<(), Failed> {
    let at = |index: i32| Pose::new(1.0 + 0.002 * f64::from(index), 2.5, 0.005 * f64::from(index));
    let problem = |index| QuantizedProblem::new(&Problem { pose: at(index), ..plain() });
    let problems = (0..=4 * 256).map(problem).collect::<Result<Vec<_>, _>>()?;
    let answers = expected(&problems, Detail::Answer)?;
    if answers.windows(2).any(|pair| pair[0] == pair[1]) {
        return Err("neighbours with one answer: a swapped one could not show".into());
    }
    let engine = &mut GpuEngine::new(adapter)?;
    same(engine, "first", &problems)?;
    // The memory of both transfers is used again.
    same(engine, "again, backwards", &problems.iter().rev().cloned().collect::<Vec<_>>())
}

/// Fields that appear, disappear and stay, with odd and even numbers of cells.
pub fn fields(adapter: &Adapter) -> Result<(), Failed> {
    let all = problems(45, 24)?;
    let engine = &mut GpuEngine::new(adapter)?;
    for chosen in [
        &[0][..],
        &[1],
        &[0, 1],
        &[1, 0, 1, 0],
        &[2, 1],
        &[3, 4, 5, 6, 7, 8, 9, 10],
        &[0],
        &[9, 3],
        &[0, 5, 11, 12],
        &[13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23],
        &[4, 4, 4],
        &[23, 0, 22, 1],
    ] {
        let batch: Vec<QuantizedProblem> = chosen.iter().map(|&index| all[index].clone()).collect();
        same(engine, &format!("problems {chosen:?}"), &batch)?;
    }
    Ok(())
}

/// Fields of 1.3 MB: the first buffer holds only one, so fields must be replaced and uploaded again.
pub fn large_fields(adapter: &Adapter) -> Result<(), Failed> {
    let beside = |column| {
        QuantizedProblem::new(&Problem { field: field(801, 0.1, &[[column, 25]]), ..plain() })
    };
    let all = [beside(29)?, beside(30)?, beside(31)?];
    let answers = expected(&all, Detail::Answer)?;
    if answers[0] == answers[1] || answers[1] == answers[2] {
        return Err("worlds with one answer: a stale one could not show".into());
    }
    let engine = &mut GpuEngine::new(adapter)?;
    for chosen in [&[0][..], &[1], &[0], &[0, 1], &[2], &[1], &[0, 2], &[2, 1, 0]] {
        let batch: Vec<QuantizedProblem> = chosen.iter().map(|&index| all[index].clone()).collect();
        same(engine, &format!("worlds {chosen:?}"), &batch)?;
    }
    Ok(())
}

/// A problem that the adapter rejects alone is rejected in a batch too, and later batches work.
pub fn refusals(adapter: &Adapter) -> Result<(), Failed> {
    let engine = &mut GpuEngine::new(adapter)?;
    let easy = QuantizedProblem::new(&plain())?;
    for (what, problem) in extremes() {
        let problem = QuantizedProblem::new(&problem)?;
        let batch = [easy.clone(), problem.clone(), easy.clone()];
        match engine.evaluate(&problem, Detail::Answer) {
            Ok(_) => same(engine, what, &batch)?,
            Err(alone) => match engine.evaluate_batch(&batch, Detail::Answer) {
                Err(refusal) if refusal == alone => {}
                other => return Err(format!("{what}: {other:?}, not {alone}").into()),
            },
        }
    }
    // At the end of the longest batch: finding the problem takes the most loop iterations there.
    let crowd =
        extremes().into_iter().find(|(what, _)| what.starts_with("as many moving obstacles"));
    let (what, crowd) = crowd.ok_or("no such problem")?;
    let mut longest = vec![easy.clone(); 256];
    longest[255] = QuantizedProblem::new(&crowd)?;
    same(engine, what, &longest)?;
    // 4.8 GB of tables: more than an adapter can bind.
    let axis = |count| Axis::new(-0.5, 0.5, count);
    let too_large = Problem {
        window: Window { vx: axis(1), vtheta: axis(65_536) },
        steps: 1023,
        step_s: 0.01,
        footprint: footprint(&[[0.0, 0.0, 0.2]; 8]),
        ..plain()
    };
    let batch = [easy.clone(), QuantizedProblem::new(&too_large)?, easy.clone()];
    match engine.evaluate_batch(&batch, Detail::Answer) {
        Err(EngineError::TooLarge { message, .. }) if message.contains("sample less densely") => {}
        other => return Err(format!("too large, yet {other:?}").into()),
    }
    same(engine, "after refusals", &[easy.clone(), easy])
}

/// Name and falsification of an adapter's answers.
type Falsification = (&'static str, fn(&mut Vec<Evaluation>));

/// A fault in one of many answers must be reported.
pub fn falsified(adapter: &Adapter) -> Result<(), Failed> {
    const FALSIFICATIONS: [Falsification; 6] = [
        ("two answers swapped", |found| found.swap(3, 4)),
        ("an answer given twice", |found| found[5] = found[6].clone()),
        ("an answer left out", |found| {
            found.remove(2);
        }),
        ("one bit of a sum", |found| {
            found[6].totals.sums[3] ^= 1 << 33;
        }),
        ("one bit of a count", |found| found[0].counts.outside ^= 1),
        ("one bit of a sample", |found| {
            let samples = found[1].samples.as_mut();
            samples.expect("samples are requested")[0].terms.path ^= 1;
        }),
    ];
    let problems = problems(46, 7)?;
    let expected = expected(&problems, Detail::Samples)?;
    let found = GpuEngine::new(adapter)?.evaluate_batch(&problems, Detail::Samples)?;
    if let Some(difference) = differences(&expected, &found) {
        return Err(format!("nothing was falsified, yet {difference}").into());
    }
    for (what, falsify) in FALSIFICATIONS {
        let mut found = found.clone();
        falsify(&mut found);
        if differences(&expected, &found).is_none() {
            return Err(format!("{what} went unnoticed").into());
        }
    }
    Ok(())
}
