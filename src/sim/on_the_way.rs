//! People spread along the way that the robot will plan.

use super::MovingObstacles;
use crate::geometry::Point;
use crate::map::OccupancyGrid;
use crate::navigator::Fault;
use crate::runtime::{Config, MissionError};

impl MovingObstacles {
    /// So many people, as the settings have them, along the way from the first of the ends to the second.
    ///
    /// # Errors
    /// When there is no such way, or no room for people along it.
    pub fn on_route(
        count: usize,
        seed: u64,
        map: &OccupancyGrid,
        config: &Config,
        (start, goal): (Point, Point),
    ) -> Result<Self, MissionError> {
        if count == 0 {
            return Ok(Self::default());
        }
        let obstacles = map.obstacles(config.unknown);
        let mut planner = config.route_planner(map.frame().resolution_m);
        let plan = planner
            .plan(&obstacles, start, goal, &mut || 0.0)
            .map_err(Fault::Plan)?;
        let crowd = config.pedestrians.crowd(count, seed);
        let way = plan.smoothed.points();
        Ok(Self::seeded(&crowd, &obstacles, way, &[start, goal])?)
    }
}
