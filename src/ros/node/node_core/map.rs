//! The map of the navigator, and its changes.

use super::NodeCore;
use crate::navigator::NavigationMap;
use crate::ros::node::notices::MissingInput;

impl NodeCore {
    /// The newest map with its zones.
    pub(super) fn navigation_map(&self) -> Option<NavigationMap> {
        let map = self.inputs.map.as_ref()?;
        let config = &self.settings.config;
        let zones = self.zones.on(map.grid.frame(), config.robot.limits.max_vel_x);
        Some(NavigationMap { obstacles: map.grid.obstacles(config.unknown), zones })
    }

    /// What keeps the zones from being used on the map.
    pub(super) fn missing_zones(&self) -> Option<MissingInput> {
        let map = self.inputs.map.as_ref()?;
        self.zones.missing(&map.frame)
    }

    /// Prepares the map for a navigator that drives, if it or its zones have changed.
    pub(super) fn prepare_if(&mut self, is_new: bool) {
        if !is_new || self.navigator.is_none() || self.ended_s.is_some() {
            return;
        }
        let is_started = self
            .navigation_map()
            .is_some_and(|map| self.map_update.start(&map, &self.settings.config));
        if !is_started {
            self.navigator = None;
        }
    }

    /// Gives the navigator a changed map that is prepared.
    pub(super) fn update_map(&mut self) {
        let mut map_update = std::mem::take(&mut self.map_update);
        let newest = || self.navigation_map();
        let taken = map_update.take(newest, &self.settings.config);
        self.map_update = map_update;
        match (taken, &mut self.navigator) {
            (Ok(Some(prepared)), Some(navigator)) => navigator.replace_map(prepared),
            (Ok(_), _) => {}
            // The robot stops, and a new navigator plans.
            (Err(()), _) => self.navigator = None,
        }
    }
}
