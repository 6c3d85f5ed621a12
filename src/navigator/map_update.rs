//! A new map for a navigator that drives.

use std::sync::Arc;

use super::async_planner::AsyncPlanner;
use super::obstacle_model::LocalMap;
use super::occlusion::standing_room;
use super::replanning::Reason;
use super::{Fault, GlobalPlanner, NavigationMap, Navigator, NavigatorSettings};
use crate::map::{FreeSpace, Zones};

/// What a navigator needs of a new map. To prepare it takes time in proportion to the map's area: do it on another thread.
pub struct PreparedMap {
    pub(super) local: LocalMap,
    pub(super) standing_room: Option<FreeSpace>,
    pub(super) planner: AsyncPlanner<Reason>,
    pub(super) zones: Option<Arc<Zones>>,
}

impl PreparedMap {
    /// Prepares a map for a navigator with these settings.
    ///
    /// # Errors
    /// When the planning thread does not start.
    pub fn new(
        map: impl Into<NavigationMap>,
        planner: Box<dyn GlobalPlanner>,
        settings: &NavigatorSettings,
    ) -> Result<Self, Fault> {
        let map = map.into();
        let planner = AsyncPlanner::new(map.closed(), planner)?;
        let standing_room = standing_room(&map.obstacles, settings);
        let zones = map.zones.clone();
        Ok(Self { local: LocalMap::new(map), standing_room, planner, zones })
    }
}

impl Navigator {
    /// Replaces the map, in the same frame, without a stop. The next decision avoids its obstacles, and a plan on it is requested
    /// at once. Obstacles that the lidar saw remain where the map does not show them. For a map that another program
    /// made, call [`Self::require_path_on_map`] too.
    pub fn replace_map(&mut self, map: PreparedMap) {
        self.obstacles.replace_map(map.local);
        self.standing_room = map.standing_room;
        self.zones = map.zones;
        self.replanner.replace_map(map.planner);
    }

    /// Ends the mission if there is no path on the map that just replaced the one before, even without obstacles that only the lidar
    /// saw. That takes the replanning period and twice the planning budget. Without this call the robot tries for minutes: a map that
    /// its own scans changed shows what may go away again.
    pub const fn require_path_on_map(&mut self) {
        self.replanner.require_path_on_map();
    }
}
