//! Measure: verify the answer first, then time it; medians and tails, never a mean alone.

mod density;
mod digest;
mod problems;
mod record;
mod verify;

pub use density::{DensityError, DensityPlan, measure_density};
pub use digest::EvaluationDigest;
pub use problems::random_problem;
pub use record::DensityRow;
pub use verify::{Difference, Verification, VerifyError, compare, verify};
