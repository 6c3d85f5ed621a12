//! Measurements: answers are verified before they are timed; times are medians and tails.

pub(crate) mod columns;
mod crossover;
mod deadlines;
mod density;
mod digest;
mod error;
mod golden;
pub mod movingai;
pub mod paper;
mod problems;
mod quality;
mod record;
mod regret;
mod roadway;
mod timing;
mod verify;

#[cfg(feature = "report")]
pub(crate) use columns::csv_line;
pub use columns::{Column, ColumnKind, ColumnValue, Columns, csv_text, text_table};
pub use crossover::{Crossover, crossovers};
pub use deadlines::{Misses, RATES_HZ};
pub use density::{Density, DensityPlan, measure_density};
pub use digest::EvaluationDigest;
pub use error::BenchError;
pub use golden::{GOLDEN_CASES, GOLDEN_DIGEST, GOLDEN_SEED, verify_golden};
pub use problems::random_problem;
pub use quality::{QualityPlan, grid_counts, measure_quality};
pub use record::{DensityRow, QualityRow, SkippedCell};
pub use regret::RegretBaseline;
pub use roadway::{Roadway, roadway_field, roadway_obstacles};
pub use timing::{Latencies, LatencySummary};
pub use verify::{Difference, Verification, compare, verify};
