//! Work compiled for instructions that not every x86-64 processor has.
#![expect(
    unsafe_code,
    reason = "calls of functions that are compiled for certain instructions"
)]

use super::instructions::Work;
use super::lanes::{Avx2, Avx512, Lanes};

#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
fn with_avx2<W: Work>(proof: <Avx2 as Lanes>::Proof, work: W) -> W::Outcome {
    work.run::<Avx2>(proof)
}

#[target_feature(enable = "avx512f,avx512bw,avx512cd,avx512dq,avx512vl,bmi1,bmi2,lzcnt,popcnt")]
fn with_avx512<W: Work>(proof: <Avx512 as Lanes>::Proof, work: W) -> W::Outcome {
    work.run::<Avx512>(proof)
}

/// Does it with AVX2.
pub fn avx2<W: Work>(proof: <Avx2 as Lanes>::Proof, work: W) -> W::Outcome {
    // SAFETY: the proof shows that the processor has what the function is compiled for.
    unsafe { with_avx2(proof, work) }
}

/// Does it with AVX-512.
pub fn avx512<W: Work>(proof: <Avx512 as Lanes>::Proof, work: W) -> W::Outcome {
    // SAFETY: the proof shows that the processor has what the function is compiled for.
    unsafe { with_avx512(proof, work) }
}
