//! The golden digest, the same on every machine.

use super::{BenchError, Verification, verify};
use crate::local::Engine;

/// Seed of the problems whose digest is pinned.
pub const GOLDEN_SEED: u64 = 2026;
/// Number of those problems.
pub const GOLDEN_CASES: u64 = 64;
/// Digest over every bit of their evaluations, on any engine and machine. It changes only with the engines' specification
/// or with [`super::random_problem`]; document every such change.
pub const GOLDEN_DIGEST: &str = "3015f2d5433f8a8f24842201aa2a2422026759ef9d43cc3c5b991d13b409f6da";

/// Evaluates the problems of the golden digest on every engine.
///
/// # Errors
/// Fails when an engine gives no answer.
pub fn verify_golden(engines: &mut [Box<dyn Engine>]) -> Result<Verification, BenchError> {
    verify(engines, GOLDEN_CASES, GOLDEN_SEED, |_| {})
}
