//! Planning errors, with Nav2's error codes.

use thiserror::Error;

use crate::settings::SettingError;

use crate::geometry::Point;

/// Why no path was planned.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum PlanError {
    /// The start is outside the map.
    #[error("START_OUTSIDE_MAP: start ({:.2}, {:.2}) {why}", place.x, place.y)]
    StartOutsideMap {
        /// The start.
        place: Point,
        /// The cause, and the nearest free point.
        why: String,
    },
    /// The goal is outside the map.
    #[error("GOAL_OUTSIDE_MAP: goal ({:.2}, {:.2}) {why}", place.x, place.y)]
    GoalOutsideMap {
        /// The goal.
        place: Point,
        /// The cause, and the nearest free point.
        why: String,
    },
    /// The start is in or too close to an obstacle.
    #[error("START_OCCUPIED: start ({:.2}, {:.2}) {why}", place.x, place.y)]
    StartOccupied {
        /// The start.
        place: Point,
        /// The cause, and the nearest free point.
        why: String,
    },
    /// The goal is in or too close to an obstacle.
    #[error("GOAL_OCCUPIED: goal ({:.2}, {:.2}) {why}", place.x, place.y)]
    GoalOccupied {
        /// The goal.
        place: Point,
        /// The cause, and the nearest free point.
        why: String,
    },
    /// Start and goal are not connected.
    #[error(
        "NO_VALID_PATH: no path from ({:.2}, {:.2}) to ({:.2}, {:.2}) {}",
        start.x, start.y, goal.x, goal.y,
        reason.as_ref().map_or_else(|| search_text((*radius_m, *turning_radius_m), *expanded, nearest.as_ref()), Clone::clone)
    )]
    NoValidPath {
        /// The start.
        start: Point,
        /// The goal.
        goal: Point,
        /// Clearance required, metres.
        radius_m: f64,
        /// Clearance that the robot needs to turn on the spot, metres, where its body was searched with its heading: it is longer than
        /// wide. `radius_m` is then that to each side.
        turning_radius_m: Option<f64>,
        /// Number of expanded cells.
        expanded: u32,
        /// The reachable cell centre nearest to the goal.
        nearest: Option<Point>,
        /// Why there is none, after "no path from here to there", where the search alone does not say it: the name and reason of the
        /// user's own global planner, or the obstacles that the map does not show.
        reason: Option<String>,
    },
    /// The user's own global planner failed, or its path is unusable.
    #[error("INVALID_PLANNER: {name}: {reason}")]
    InvalidPlanner {
        /// Name of the planner.
        name: String,
        /// The cause.
        reason: String,
    },
    /// The wait for the user's own global planner was interrupted, because the program is to end.
    #[error("INVALID_PLANNER: {name}: was interrupted")]
    Interrupted {
        /// Name of the planner.
        name: String,
    },
    /// A setting is out of range.
    #[error(transparent)]
    Setting(#[from] SettingError),
}

impl PlanError {
    /// Whether obstacles are the cause. Closed zones count as obstacles: the planner does not distinguish them.
    #[must_use]
    pub const fn is_caused_by_obstacles(&self) -> bool {
        matches!(
            self,
            Self::StartOccupied { .. } | Self::GoalOccupied { .. } | Self::NoValidPath { .. }
        )
    }

    /// Nav2's error name.
    #[must_use]
    pub const fn code(&self) -> &'static str {
        match self {
            Self::StartOutsideMap { .. } => "START_OUTSIDE_MAP",
            Self::GoalOutsideMap { .. } => "GOAL_OUTSIDE_MAP",
            Self::StartOccupied { .. } => "START_OCCUPIED",
            Self::GoalOccupied { .. } => "GOAL_OCCUPIED",
            Self::NoValidPath { .. } => "NO_VALID_PATH",
            Self::InvalidPlanner { .. } | Self::Interrupted { .. } => "INVALID_PLANNER",
            Self::Setting(_) => "BAD_SETTING",
        }
    }
}

/// What a search without a path found. The nearest reachable point is exact to the millimetre, so that it lies in the cell found.
fn search_text(
    (radius_m, turning_radius_m): (f64, Option<f64>),
    expanded: u32,
    nearest: Option<&Point>,
) -> String {
    let (room, size) = match turning_radius_m {
        None => (
            format!("keeps {radius_m:.3} m from every obstacle"),
            "a smaller radius (that of the footprint and its margins)",
        ),
        Some(turning_m) => (
            format!(
                "has room for the robot, {radius_m:.3} m to each side of its middle and {turning_m:.3} m around it where it turns"
            ),
            "a smaller footprint or margin,",
        ),
    };
    // The search that failed is not always the one that counts its cells.
    let cells = match expanded {
        0 => String::new(),
        expanded => format!(" ({expanded} cells searched)"),
    };
    let nearest = nearest.map_or_else(String::new, |point| {
        format!("; the reachable point nearest to the goal is ({:.3}, {:.3})", point.x, point.y)
    });
    format!("{room}{cells}{nearest}: choose a goal on the same side, {size} or a finer map")
}
