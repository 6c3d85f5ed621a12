//! Which way: the global path on a grid, searched, pruned and smoothed (paper, section 3).

mod astar;
mod basis;
mod clearance;
mod cost;
mod curvature;
mod error;
mod heuristic;
mod line_of_sight;
mod path;
mod plan;
mod prune;
mod reachable;
mod settings;
mod spline;

pub use astar::{Found, NotFound, astar};
pub use clearance::min_clearance_m;
pub use cost::{DIAGONAL, STRAIGHT};
pub use curvature::{Curvature, Spline};
pub use error::PlanError;
pub use heuristic::Heuristic;
pub use line_of_sight::is_clear;
pub use path::{Path, Projection};
pub use plan::{Ground, Plan, StageTimes, plan};
pub use prune::prune;
pub use reachable::nearest_reachable;
pub use settings::Settings;
pub use spline::smooth;
