//! The kernels compiled for instructions that not every x86-64 processor has.
#![expect(
    unsafe_code,
    reason = "calls of functions that are compiled for certain instructions"
)]

use super::choice::{Share, largest_score};
use super::course::Course;
use super::lanes::{Avx2, Avx512, Lanes};
use super::part::Part;
use super::yardstick::gather_only;
use crate::local::Prepared;

#[target_feature(enable = "avx2")]
fn choose_avx2(course: &Course, row: &[i32], samples: usize, shares: &[Share; 4]) -> i64 {
    largest_score(course, row, samples, shares)
}

#[target_feature(enable = "avx512f,avx512bw,avx512cd")]
fn choose_avx512(course: &Course, row: &[i32], samples: usize, shares: &[Share; 4]) -> i64 {
    largest_score(course, row, samples, shares)
}

/// The largest score of a row with AVX2.
pub fn largest_avx2(
    _: <Avx2 as Lanes>::Proof,
    course: &Course,
    row: &[i32],
    samples: usize,
    shares: &[Share; 4],
) -> i64 {
    // SAFETY: the proof shows that the processor has what the function is compiled for.
    unsafe { choose_avx2(course, row, samples, shares) }
}

/// The largest score of a row with AVX-512.
pub fn largest_avx512(
    _: <Avx512 as Lanes>::Proof,
    course: &Course,
    row: &[i32],
    samples: usize,
    shares: &[Share; 4],
) -> i64 {
    // SAFETY: the proof shows that the processor has what the function is compiled for.
    unsafe { choose_avx512(course, row, samples, shares) }
}

#[target_feature(enable = "avx2")]
fn avx2(proof: <Avx2 as Lanes>::Proof, part: &mut Part, problem: &Prepared, course: &Course) {
    part.judge_lanes::<Avx2>(proof, problem, course);
}

#[target_feature(enable = "avx512f,avx512bw,avx512cd")]
fn avx512(proof: <Avx512 as Lanes>::Proof, part: &mut Part, problem: &Prepared, course: &Course) {
    part.judge_lanes::<Avx512>(proof, problem, course);
}

/// Judges with AVX2.
pub fn judge_avx2(
    proof: <Avx2 as Lanes>::Proof,
    part: &mut Part,
    problem: &Prepared,
    course: &Course,
) {
    // SAFETY: the proof shows that the processor has what the function is compiled for.
    unsafe { avx2(proof, part, problem, course) };
}

/// Judges with AVX-512.
pub fn judge_avx512(
    proof: <Avx512 as Lanes>::Proof,
    part: &mut Part,
    problem: &Prepared,
    course: &Course,
) {
    // SAFETY: the proof shows that the processor has what the function is compiled for.
    unsafe { avx512(proof, part, problem, course) };
}

#[target_feature(enable = "avx2")]
fn only_avx2(proof: <Avx2 as Lanes>::Proof, list: &[u16], cells: &[i32]) -> i32 {
    gather_only::<Avx2>(proof, list, cells)
}

#[target_feature(enable = "avx512f,avx512bw,avx512cd")]
fn only_avx512(proof: <Avx512 as Lanes>::Proof, list: &[u16], cells: &[i32]) -> i32 {
    gather_only::<Avx512>(proof, list, cells)
}

/// Gathers with AVX2.
pub fn gather_avx2(proof: <Avx2 as Lanes>::Proof, list: &[u16], cells: &[i32]) -> i32 {
    // SAFETY: the proof shows that the processor has what the function is compiled for.
    unsafe { only_avx2(proof, list, cells) }
}

/// Gathers with AVX-512.
pub fn gather_avx512(proof: <Avx512 as Lanes>::Proof, list: &[u16], cells: &[i32]) -> i32 {
    // SAFETY: the proof shows that the processor has what the function is compiled for.
    unsafe { only_avx512(proof, list, cells) }
}
