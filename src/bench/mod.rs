//! Measurements: answers are verified before they are timed; times are medians and tails.

mod batches;
pub(crate) mod columns;
mod density;
mod engine_times;
mod error;
mod log_localization;
mod log_perception;
#[cfg(test)]
mod lost_gpu;
pub mod movingai;
pub mod paper;
mod problems;
mod quality;
mod roadway;
mod timing;
mod verify;

pub use batches::{BatchRow, measure_batches};
pub use columns::{Column, ColumnKind, ColumnValue, Columns, csv_text, text_table};
pub use density::{
    Crossover, Density, DensityPlan, DensityRow, LostEngine, SkippedCell, crossovers,
    measure_density, named_sampler,
};
pub use engine_times::{DecisionSize, EngineRequest, EngineTime, measure_engines, open_requested};
pub use error::BenchError;
pub use log_localization::{
    LogLocalization, LogRelations, RelationErrors, corrected_pairs, localize_log,
};
pub use log_perception::{LogPerception, Perceived, perceive_log};
pub use problems::random_problem;
pub use quality::{
    QualityPlan, QualityRow, RegretBaseline, grid_counts, measure_quality, usual_shape,
};
pub use roadway::{Roadway, roadway_field, roadway_obstacles};
pub use timing::{
    Latencies, LatencySummary, Misses, RATES_HZ, percentile, percentiles, wilson_interval,
};
pub use verify::{
    Difference, EvaluationDigest, GOLDEN_CASES, GOLDEN_DIGEST, GOLDEN_SEED, Verification, compare,
    verify, verify_golden,
};

use crate::global::{CellPath, Heuristic, NoPath, Searcher};
use crate::map::{Cell, FreeSpace};

/// Searches by A* with a heuristic, or by jump points without one.
fn search_grid<'a>(
    searcher: &'a mut Searcher,
    space: &FreeSpace,
    [start, goal]: [Cell; 2],
    heuristic: Option<Heuristic>,
) -> Result<CellPath<'a>, NoPath> {
    match heuristic {
        Some(heuristic) => searcher.astar(space, start, goal, heuristic, None),
        None => searcher.jump_points(space, start, goal),
    }
}
