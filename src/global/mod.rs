//! Global path planning on a grid: search, pruning and smoothing (paper, section 3).

mod body_moves;
mod body_path;
mod body_search;
mod bspline;
mod clearance_cost;
mod curvature;
mod error;
mod heuristic;
mod line_of_sight;
mod path;
mod path_clearance;
mod plan;
mod prune;
mod search;
mod settings;
mod spline;

pub use body_path::BodySpace;
pub use clearance_cost::ClearanceCosts;
pub use curvature::{Curvature, Spline};
pub use error::PlanError;
pub use heuristic::{DIAGONAL, Estimator, Heuristic, STRAIGHT};
pub use line_of_sight::is_clear;
pub use path::{Path, Projection};
pub use path_clearance::PathClearance;
pub use plan::{Plan, PlanningSpace, StageTimes, nearest_reachable, plan};
pub(crate) use plan::{free_goal_cell, nearest_free, nearest_reachable_within, too_near};
pub use prune::prune;
pub use search::{CellPath, NoPath, Searcher};
pub use settings::{Pruning, SearchMethod, Settings};
pub use spline::smooth;
