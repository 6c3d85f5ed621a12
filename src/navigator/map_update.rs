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

/// Where a new map comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MapSource {
    /// A user or another program. The mission ends if there is no path on the map, even without obstacles that only the lidar saw. That
    /// takes the replanning period and twice the planning budget.
    Given,
    /// The robot's own scans. What they show may go away again: without a path the robot tries for minutes.
    Scans,
}

impl Navigator {
    /// Replaces the map, in the same frame, without a stop. The next decision avoids its obstacles, and a plan on it is requested
    /// at once. Obstacles that the lidar saw remain where the map does not show them.
    pub fn replace_map(&mut self, map: PreparedMap, source: MapSource) {
        self.obstacles.replace_map(map.local);
        self.standing_room = map.standing_room;
        self.zones = map.zones;
        self.replanner.replace_map(map.planner, source);
    }
}
