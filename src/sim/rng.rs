//! Seeded random numbers of the simulation.

use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

pub(super) use crate::base::standard_normal;

/// The streams of random numbers of a run. They are independent: a change of one leaves the others unchanged. The values
/// are arbitrary.
#[derive(Clone, Copy)]
#[repr(u64)]
pub(super) enum RngStream {
    Ground = 0x6a09_e667_f3bc_c908,
    Odometry = 0xbb67_ae85_84ca_a73b,
    Fixes = 0x3c6e_f372_fe94_f82b,
    Obstacles = 0xa54f_f53a_5f1d_36f1,
}

/// Returns the generator of a stream.
pub(super) fn generator(seed: u64, source: RngStream) -> Pcg64Mcg {
    Pcg64Mcg::seed_from_u64(seed ^ source as u64)
}

/// Draws from a normal distribution with mean zero. A deviation of zero gives zero and draws nothing.
pub(super) fn normal(rng: &mut Pcg64Mcg, deviation: f64) -> f64 {
    if deviation > 0.0 { deviation * standard_normal(rng) } else { 0.0 }
}
