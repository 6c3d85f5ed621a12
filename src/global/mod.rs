//! Which way: the global path on a grid, searched, pruned and smoothed (paper, section 3).

mod bspline;
mod path_clearance;
mod clearance_cost;
mod cost;
mod curvature;
mod error;
mod heuristic;
mod line_of_sight;
mod path;
mod plan;
mod prune;
mod reachable;
mod search;
mod settings;
mod spline;

pub use path_clearance::{PathClearance, min_clearance_m};
pub use clearance_cost::{ClearanceCosts, MAX_CLEARANCE_WEIGHT};
pub use cost::{DIAGONAL, STRAIGHT};
pub use curvature::{Curvature, Spline};
pub use error::PlanError;
pub use heuristic::Heuristic;
pub use line_of_sight::is_clear;
pub use path::{Path, Projection};
pub use plan::{PlanningSpace, Plan, StageTimes, plan};
pub use prune::prune;
pub use reachable::nearest_reachable;
pub use search::{CellPath, NoPath, Searcher};
pub use settings::{SearchMethod, Pruning, Settings};
pub use spline::smooth;
