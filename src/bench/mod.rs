//! Measure: verify the answer first, then time it; medians and tails, never a mean alone.

mod digest;
mod problems;
mod record;
mod verify;

pub use digest::EvaluationDigest;
pub use problems::random_problem;
pub use record::DensityRow;
pub use verify::{Difference, Verification, VerifyError, compare, verify};
