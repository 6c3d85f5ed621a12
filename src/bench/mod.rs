//! Measure: verify the answer first, then time it; medians and tails, never a mean alone.

mod record;

pub use record::DensityRow;
