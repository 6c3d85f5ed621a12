//! Measure: verify the answer first, then time it; medians and tails, never a mean alone.

mod density;
mod digest;
mod error;
mod golden;
mod problems;
mod record;
mod roadway;
mod timing;
mod verify;

pub use density::{DensityPlan, measure_density};
pub use digest::EvaluationDigest;
pub use error::BenchError;
pub use golden::{GOLDEN_CASES, GOLDEN_DIGEST, GOLDEN_SEED, verify_golden};
pub use problems::random_problem;
pub use record::DensityRow;
pub use roadway::{Roadway, roadway_field, roadway_obstacles};
pub use timing::{Latencies, LatencySummary};
pub use verify::{Difference, Verification, compare, verify};
