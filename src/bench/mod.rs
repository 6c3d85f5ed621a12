//! Measure: verify the answer first, then time it; medians and tails, never a mean alone.

mod error;
mod record;
mod timing;

pub use error::BenchError;
pub use record::DensityRow;
pub use timing::{Latencies, LatencySummary};
