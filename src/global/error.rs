//! Why there is no path, in Nav2's words.

use thiserror::Error;

use crate::geometry::Point;

/// A query without a path.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum PlanError {
    /// The start lies off the map.
    #[error("START_OUTSIDE_MAP: start ({:.2}, {:.2}) {why}", place.x, place.y)]
    StartOutsideMap {
        /// The start.
        place: Point,
        /// What is wrong, and the nearest free point.
        why: String,
    },
    /// The goal lies off the map.
    #[error("GOAL_OUTSIDE_MAP: goal ({:.2}, {:.2}) {why}", place.x, place.y)]
    GoalOutsideMap {
        /// The goal.
        place: Point,
        /// What is wrong, and the nearest free point.
        why: String,
    },
    /// The start is in or too near an obstacle.
    #[error("START_OCCUPIED: start ({:.2}, {:.2}) {why}", place.x, place.y)]
    StartOccupied {
        /// The start.
        place: Point,
        /// What is in the way, and the nearest free point.
        why: String,
    },
    /// The goal is in or too near an obstacle.
    #[error("GOAL_OCCUPIED: goal ({:.2}, {:.2}) {why}", place.x, place.y)]
    GoalOccupied {
        /// The goal.
        place: Point,
        /// What is in the way, and the nearest free point.
        why: String,
    },
    /// Start and goal are not connected.
    #[error(
        "NO_VALID_PATH: no way from ({:.2}, {:.2}) to ({:.2}, {:.2}) that keeps {radius_m:.3} m from every obstacle \
         ({expanded} cells searched){}: choose a goal on the same side, a smaller radius (that of the footprint and its \
         margins) or a finer map",
        start.x, start.y, goal.x, goal.y, as_far_as(nearest.as_ref())
    )]
    NoValidPath {
        /// The start.
        start: Point,
        /// The goal.
        goal: Point,
        /// Distance kept.
        radius_m: f64,
        /// Cells expanded.
        expanded: u32,
        /// The point nearest to the goal, a cell's centre, that can be reached from the start.
        nearest: Option<Point>,
    },
    /// A setting out of range.
    #[error("{name} is {value}: it must be {expected}")]
    BadSetting {
        /// Its name.
        name: &'static str,
        /// As given.
        value: f64,
        /// What would be accepted.
        expected: &'static str,
    },
}

impl PlanError {
    /// Nav2's name of the error.
    #[must_use]
    pub const fn code(&self) -> &'static str {
        match self {
            Self::StartOutsideMap { .. } => "START_OUTSIDE_MAP",
            Self::GoalOutsideMap { .. } => "GOAL_OUTSIDE_MAP",
            Self::StartOccupied { .. } => "START_OCCUPIED",
            Self::GoalOccupied { .. } => "GOAL_OCCUPIED",
            Self::NoValidPath { .. } => "NO_VALID_PATH",
            Self::BadSetting { .. } => "BAD_SETTING",
        }
    }
}

/// How near to the goal one gets, to the millimetre: near enough to lie in the cell that was found.
fn as_far_as(nearest: Option<&Point>) -> String {
    nearest.map_or_else(String::new, |point| {
        format!(
            "; the reachable point nearest to the goal is ({:.3}, {:.3})",
            point.x, point.y
        )
    })
}
