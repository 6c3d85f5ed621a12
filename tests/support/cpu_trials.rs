//! Parity tests without an adapter: threads, instruction sets, the pinned digest, and faults that the comparison must
//! report.

use inbye::bench::{Difference, GOLDEN_DIGEST, compare, random_problem, verify, verify_golden};
use inbye::local::{
    Axis, CpuEngine, Detail, Engine, Evaluation, InstructionSet, Problem, QuantizedProblem, Window,
};
use libtest_mimic::{Failed, Trial};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::batch_trials::random_batches;
use super::changed_engine::ChangedEngine;
use super::operations::{OPERATIONS, cases, differences};

pub fn trials() -> Vec<Trial> {
    vec![
        Trial::test("threads_change_no_bit", threads_change_no_bit),
        Trial::test("batches_on_threads_change_no_bit", batches_on_threads_change_no_bit),
        Trial::test("instruction_sets_change_no_bit", instruction_sets_change_no_bit),
        Trial::test("step_pruning_changes_no_bit", step_pruning_changes_no_bit),
        Trial::test("digest_equals_the_pinned_one", digest_equals_the_pinned_one),
        Trial::test("one_flipped_bit_is_reported", one_flipped_bit_is_reported),
        Trial::test("one_flipped_bit_of_an_operation_is_reported", a_flipped_bit_of_an_operation),
    ]
}

fn threads_change_no_bit() -> Result<(), Failed> {
    let mut engines: Vec<Box<dyn Engine>> = Vec::new();
    for threads in 1..=3 {
        let mut engine = CpuEngine::with_threads(threads)?;
        engine.use_all_threads();
        engines.push(Box::new(engine));
    }
    agree(&mut engines, 200, 31)
}

/// Batches that all threads divide, that they take together, and of more and fewer problems than threads.
fn batches_on_threads_change_no_bit() -> Result<(), Failed> {
    let batches = [(0, 1), (1, 2), (3, 7), (10, 64), (74, 0), (0, 100), (20, 3)];
    for threads in [1, 2, 5] {
        let mut engine = CpuEngine::with_threads(threads)?;
        random_batches(&mut engine, 46, &batches)?;
        engine.use_all_threads();
        random_batches(&mut engine, 46, &batches)?;
    }
    Ok(())
}

/// One engine per available instruction set, the scalar reference first.
fn all_instruction_sets() -> Result<Vec<Box<dyn Engine>>, Failed> {
    let mut engines: Vec<Box<dyn Engine>> = Vec::new();
    for instructions in InstructionSet::ALL {
        if instructions.is_available() {
            engines.push(Box::new(CpuEngine::with_instruction_set(instructions, 1)?));
        }
    }
    Ok(engines)
}

fn instruction_sets_change_no_bit() -> Result<(), Failed> {
    agree(&mut all_instruction_sets()?, 600, 32)
}

/// Rows of several chunks and vectors. Most stay on the field: step pruning applies.
fn step_pruning_changes_no_bit() -> Result<(), Failed> {
    let mut engines = all_instruction_sets()?;
    let rng = &mut Pcg64Mcg::seed_from_u64(35);
    let mut admissible = 0;
    for case in 0..400 {
        let random = random_problem(36, case);
        let slower = rng.random_range(0.05..0.6);
        let linear = Axis::new(
            random.window.vx.low * slower,
            random.window.vx.high * slower,
            rng.random_range(1..=400),
        );
        // In every other case there are many close turn rates, so that rows share a tile.
        let axis = random.window.vtheta;
        let angular = if case % 2 == 0 {
            Axis { count: rng.random_range(1..=4), ..axis }
        } else {
            Axis {
                high: axis.low + (axis.high - axis.low) * 0.1,
                count: rng.random_range(8..=40),
                ..axis
            }
        };
        let problem = QuantizedProblem::new(&Problem {
            window: Window { vx: linear, vtheta: angular },
            ..random
        })?;
        let expected = engines[0].evaluate(&problem, Detail::Samples)?;
        admissible += expected.counts.admissible;
        for engine in &mut engines[1..] {
            let found = engine.evaluate(&problem, Detail::Samples)?;
            let mut first = None;
            compare(&expected, &found, |what, expected, found| {
                first.get_or_insert(format!("{what}: {found}, not {expected}"));
            });
            if let Some(first) = first {
                return Err(format!("{}, case {case}: {first}", engine.name()).into());
            }
        }
    }
    if admissible < 20_000 {
        return Err(format!("only {admissible} admissible samples: too few to compare").into());
    }
    Ok(())
}

fn digest_equals_the_pinned_one() -> Result<(), Failed> {
    golden(Box::new(CpuEngine::single_threaded()))
}

/// Compares an engine's digest with the pinned one.
pub fn golden(engine: Box<dyn Engine>) -> Result<(), Failed> {
    let verification = verify_golden(&mut [engine])?;
    match verification.digests.as_slice() {
        [digest] if digest == GOLDEN_DIGEST => Ok(()),
        digests => Err(format!("{digests:?} is not the pinned digest {GOLDEN_DIGEST}").into()),
    }
}

/// Compares engines on random problems.
pub fn agree(engines: &mut [Box<dyn Engine>], problems: u64, seed: u64) -> Result<(), Failed> {
    let verification = verify(engines, problems, seed, |_| {})?;
    if verification.agree() && verification.digests.windows(2).all(|pair| pair[0] == pair[1]) {
        return Ok(());
    }
    let (count, samples) = (verification.difference_count, verification.samples);
    let first = &verification.differences;
    Err(format!(
        "{count} differences over {problems} problems, {samples} samples; first: {first:#?}"
    )
    .into())
}

/// Number of the problem, falsification of its evaluation, and expected report: quantity and flipped bits.
type Falsification = (fn(&mut Evaluation), &'static str, u64);

const FALSIFICATIONS: [Falsification; 9] = [
    (|found| sample(found).terms.heading ^= 1, "sample 3 heading", 1),
    (|found| sample(found).terms.clearance ^= 1 << 15, "sample 3 clearance", 1 << 15),
    (|found| sample(found).terms.velocity ^= 1 << 23, "sample 3 velocity", 1 << 23),
    (|found| sample(found).terms.path ^= 1 << 7, "sample 3 path", 1 << 7),
    (|found| found.totals.sums[3] ^= 1 << 33, "sum of path", 1 << 33),
    (|found| found.totals.min[1] ^= 1, "least clearance", 1),
    (|found| winner(found).score ^= i64::MIN, "winning score", 1 << 63),
    (|found| winner(found).index ^= 1, "winner", 1),
    (|found| found.counts.outside ^= 2, "count of outside", 2),
];

fn sample(evaluation: &mut Evaluation) -> &mut inbye::local::SampleRecord {
    &mut evaluation.samples.as_mut().expect("samples are requested")[3]
}

fn winner(evaluation: &mut Evaluation) -> &mut inbye::local::Winner {
    evaluation.winner.as_mut().expect("a problem with a winner")
}

/// The first problem of the seed with a winner and more than three samples.
fn case_with_a_winner(seed: u64) -> Result<u64, Failed> {
    for case in 0..100 {
        let problem = QuantizedProblem::new(&random_problem(seed, case))?;
        let evaluation = CpuEngine::single_threaded().evaluate(&problem, Detail::Answer)?;
        if evaluation.winner.is_some() && problem.len() > 3 {
            return Ok(case);
        }
    }
    Err("none of 100 problems has a winner".into())
}

fn one_flipped_bit_is_reported() -> Result<(), Failed> {
    let seed = 33;
    let case = case_with_a_winner(seed)?;
    for (falsify, quantity, bits) in FALSIFICATIONS {
        let mut asked = 0;
        let falsified = ChangedEngine::new(move |_, evaluation| {
            if asked == case {
                falsify(evaluation);
            }
            asked += 1;
        });
        let mut engines: [Box<dyn Engine>; 2] =
            [Box::new(CpuEngine::single_threaded()), Box::new(falsified)];
        let verification = verify(&mut engines, case + 2, seed, |_| {})?;
        let [Difference { engine, case: at, what, expected, found, .. }] =
            verification.differences.as_slice()
        else {
            return Err(format!(
                "{quantity}: not one difference but {:#?}",
                verification.differences
            )
            .into());
        };
        let flipped = number(expected)? ^ number(found)?;
        if (engine.as_str(), *at, what.as_str(), flipped) != ("changed", case, quantity, bits) {
            return Err(format!("{quantity}: reported as {:#?}", verification.differences).into());
        }
        if verification.agree() || verification.digests[0] == verification.digests[1] {
            return Err(format!("{quantity}: the digests agree").into());
        }
    }
    Ok(())
}

fn number(hexadecimal: &str) -> Result<u64, Failed> {
    Ok(u64::from_str_radix(hexadecimal.trim_start_matches("0x"), 16)?)
}

fn a_flipped_bit_of_an_operation() -> Result<(), Failed> {
    let rng = &mut Pcg64Mcg::seed_from_u64(34);
    for operation in &OPERATIONS {
        let cases = cases(operation, rng);
        let mut found: Vec<_> = cases.iter().map(|case| (operation.rust)(*case)).collect();
        if let Some(differences) = differences(operation, &cases, &found) {
            return Err(format!("nothing was flipped, yet {differences}").into());
        }
        found[777][0] ^= 1 << 31;
        let reported = differences(operation, &cases, &found);
        let expected = format!("{}: 1 of {} differ, 0 missing", operation.name, cases.len());
        if !reported.as_ref().is_some_and(|reported| reported.starts_with(&expected)) {
            return Err(
                format!("{}: a flipped bit was reported as {reported:?}", operation.name).into()
            );
        }
    }
    Ok(())
}
