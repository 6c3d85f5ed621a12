//! The map of the navigator, and its changes.

use super::NodeCore;
use crate::localization::MapChanges;
use crate::navigator::NavigationMap;
use crate::ros::convert;
use crate::ros::msg::{self, Header, Time};
use crate::ros::node::notices::MissingInput;

/// Interval at which the scans' contradictions to the map are looked at, seconds.
const INTERVAL_S: f64 = 10.0;

/// What the scans contradict in the newest map, and when that was looked at, seconds.
#[derive(Debug)]
pub(super) struct ContradictedMap {
    changes: Option<MapChanges>,
    looked_s: f64,
}

impl Default for ContradictedMap {
    fn default() -> Self {
        Self { changes: None, looked_s: f64::NEG_INFINITY }
    }
}

impl NodeCore {
    /// The newest map with its zones, and with what scans contradicted for minutes.
    pub(super) fn navigation_map(&self) -> Option<NavigationMap> {
        let map = self.inputs.map.as_ref()?;
        let config = &self.settings.config;
        let zones = self.zones.on(map.grid.frame(), config.robot.limits.max_vel_x);
        let updated = self.contradicted.changes.as_ref().map(|it| it.applied_to(&map.grid));
        let obstacles = updated.as_ref().unwrap_or(&map.grid).obstacles(config.unknown);
        Some(NavigationMap { obstacles, zones })
    }

    /// Takes over what scans contradict in the map. Returns the updated map when that has changed.
    pub(super) fn look_for_changes(&mut self, now_s: f64) -> Option<msg::OccupancyGrid> {
        if (0.0..INTERVAL_S).contains(&(now_s - self.contradicted.looked_s)) {
            return None;
        }
        self.contradicted.looked_s = now_s;
        let map = self.inputs.map.as_ref()?;
        let changes = self.localization.as_ref()?.map_changes(&map.grid)?;
        let is_same = match &self.contradicted.changes {
            Some(before) => *before == changes,
            None => changes.is_empty(),
        };
        if is_same {
            return None;
        }
        let [appeared, vanished] = changes.areas(map.grid.frame()).map(|areas| areas.len());
        self.notices.push(format!(
            "the scans contradict the map for minutes: {appeared} obstacles appeared, {vanished} vanished; the plans consider that"
        ));
        let header = Header { stamp: Time::from_seconds(now_s), frame_id: map.frame.clone() };
        let updated = convert::occupancy_grid(&changes.applied_to(&map.grid), header);
        self.contradicted.changes = Some(changes);
        self.prepare_if(true);
        Some(updated)
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
