//! A new map for a navigator that drives.

use super::async_planner::AsyncPlanner;
use super::obstacle_model::LocalMap;
use super::occlusion::standing_room;
use super::replanning::Reason;
use super::{Fault, GlobalPlanner, Navigator, NavigatorSettings};
use crate::map::{FreeSpace, ObstacleGrid};

/// What a navigator needs of a new map. To prepare it takes time in proportion to the map's area: do it on another thread.
pub struct PreparedMap {
    pub(super) local: LocalMap,
    pub(super) standing_room: Option<FreeSpace>,
    pub(super) planner: AsyncPlanner<Reason>,
}

impl PreparedMap {
    /// Prepares a map with the obstacles that it knows, for a navigator with these settings.
    ///
    /// # Errors
    /// When the planning thread does not start.
    pub fn new(
        known: ObstacleGrid,
        planner: Box<dyn GlobalPlanner>,
        settings: &NavigatorSettings,
    ) -> Result<Self, Fault> {
        let planner = AsyncPlanner::new(known.clone(), planner)?;
        let standing_room = standing_room(&known, settings);
        Ok(Self { local: LocalMap::new(known), standing_room, planner })
    }
}

impl Navigator {
    /// Replaces the map, in the same frame, without a stop. The next decision avoids its obstacles, and a plan on it is requested
    /// at once. Obstacles that the lidar saw remain where the map does not show them.
    pub fn replace_map(&mut self, map: PreparedMap) {
        self.obstacles.replace_map(map.local);
        self.standing_room = map.standing_room;
        self.replanner.replace_map(map.planner);
    }
}
