//! The kernels compiled for instructions that not every x86-64 processor has.
#![expect(
    unsafe_code,
    reason = "calls of functions that are compiled for certain instructions"
)]

use super::course::Course;
use super::lanes::{Avx2, Avx512, Lanes};
use super::part::Part;
use crate::local::Prepared;

#[target_feature(enable = "avx2")]
fn avx2(proof: <Avx2 as Lanes>::Proof, part: &mut Part, problem: &Prepared, course: &Course) {
    part.judge_lanes::<Avx2>(proof, problem, course);
}

#[target_feature(enable = "avx512f,avx512cd")]
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
