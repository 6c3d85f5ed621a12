//! The division of problems into submissions, tested without a GPU.
#![cfg(feature = "gpu")]

use std::sync::Arc;

use inbye::bench::{Roadway, roadway_field};
use inbye::local::internals::gpu::Batch;
use inbye::local::{ClearanceField, Problem, QuantizedProblem};

const MAX_BYTES: u64 = 128 << 20;

fn problem(
    field: &Arc<ClearanceField>,
    vx_samples: u32,
    vtheta_samples: u32,
    steps: u32,
) -> QuantizedProblem {
    let roadway = Roadway { vx_samples, vtheta_samples, steps, ..Roadway::default() };
    let problem = Problem { step_s: 0.01, ..roadway.problem(field, 0) };
    QuantizedProblem::new(&problem).expect("a problem within the ranges")
}

/// Number of problems of each submission.
fn submissions(problems: &[QuantizedProblem]) -> Vec<usize> {
    let batches = Batch::split(problems);
    let in_order = batches.iter().flat_map(|batch| batch.problems);
    assert!(in_order.zip(problems).all(|(one, other)| core::ptr::eq(one, other)));
    batches.iter().map(|batch| batch.problems.len()).collect()
}

#[test]
fn no_problem_makes_no_submission() {
    assert!(Batch::split(&[]).is_empty());
}

#[test]
fn submission_holds_256_problems() {
    let easy = problem(&roadway_field(), 2, 2, 1);
    assert_eq!(submissions(&vec![easy.clone(); 256]), [256]);
    assert_eq!(submissions(&vec![easy; 600]), [256, 256, 88]);
}

#[test]
fn submission_holds_as_many_samples_as_one_problem() {
    let field = &roadway_field();
    let (easy, half, whole) =
        (problem(field, 2, 2, 1), problem(field, 2048, 1024, 1), problem(field, 2048, 2048, 1));
    assert_eq!(submissions(&vec![half; 5]), [2, 2, 1]);
    assert_eq!(submissions(&[easy.clone(), whole, easy]), [1, 1, 1]);
}

#[test]
fn submission_of_several_problems_fits_buffers_of_every_adapter() {
    let field = &roadway_field();
    // 16 kB of table per turn rate.
    let (most, half) = (problem(field, 1, 9000, 1023), problem(field, 1, 4000, 1023));
    assert!(Batch::first_of(core::slice::from_ref(&most)).sizes().largest() > MAX_BYTES);
    let all = [half.clone(), most, half.clone(), half.clone(), half];
    assert_eq!(submissions(&all), [1, 1, 2, 1]);
    assert!(Batch::first_of(&all[2..]).sizes().largest() <= MAX_BYTES);
}

#[test]
fn shared_field_is_held_once() {
    let (one, other) = (roadway_field(), roadway_field());
    let problems = [problem(&one, 1, 1, 1), problem(&other, 2, 1, 1), problem(&one, 3, 1, 1)];
    let batch = Batch::first_of(&problems);
    let ids: Vec<u64> = batch.fields.iter().map(|field| field.id()).collect();
    assert_eq!(ids, [one.id(), other.id()]);
    // Two cells per word.
    let cells = one.units().len() + other.units().len();
    assert_eq!(batch.sizes().field, cells as u64 * 2);
}
