//! The interface of global planners, in the words of `nav2_core::GlobalPlanner`.

use crate::geometry::Point;
use crate::global::{Plan, PlanError};
use crate::map::{MovingDisc, ObstacleGrid};

/// Plans the paths that the navigator follows, first on the map and later with the obstacles that the scans showed.
pub trait GlobalPlanner: Send {
    /// Plans a path between two points, metres in the map frame. Cells outside the grid are obstacles. Those within the discs of
    /// `transient` may not stay, such as people who stand: a planner may keep farther from them. It may time its stages by
    /// `clock`, in seconds.
    ///
    /// # Errors
    /// When there is no path, or the planner cannot go on.
    fn plan(
        &mut self,
        obstacles: &ObstacleGrid,
        transient: &[MovingDisc],
        start: Point,
        goal: Point,
        clock: &mut dyn FnMut() -> f64,
    ) -> Result<Plan, PlanError>;

    /// The distance that the planner keeps between a path and every obstacle, metres. The navigator replans where an obstacle
    /// is nearer.
    fn least_radius_m(&self) -> f64;
}
