//! The map of the navigator, and its changes.

use super::NodeCore;
use crate::map::GridFrame;
use crate::navigator::{MapSource, NavigationMap};
use crate::ros::convert;
use crate::ros::msg::{self, Header, Time};
use crate::ros::node::action::UNKNOWN;
use crate::ros::node::incoming::{GoalInput, MapInput};
use crate::ros::node::notices::MessageError;
use crate::runtime::ContradictedMap;

impl NodeCore {
    /// Sets the map. On a changed map the robot drives on, and plans again; it stops where that is not possible.
    pub(super) fn set_map(&mut self, now_s: f64, map: MapInput) {
        let before = self.inputs.map.as_ref().map(|before| (*before.grid.frame(), &before.frame));
        let is_other_size = before != Some((*map.grid.frame(), &map.frame));
        let GridFrame { width, height, resolution_m, .. } = map.grid.frame();
        let notice = format!(
            "received a map: {width} by {height} cells of {resolution_m} m in the frame `{}`",
            map.frame
        );
        if !self.inputs.set_map(map) {
            return;
        }
        if is_other_size {
            self.notices.push(notice);
        }
        if let (Some(localization), Some(map)) = (&mut self.localization, &self.inputs.map) {
            localization.set_map(&map.grid, &map.frame);
            self.contradicted = ContradictedMap::default();
        }
        self.update_zones();
        if self.ended_s.is_some() {
            return;
        }
        if let Err(error) = self.transform_goal(now_s) {
            self.navigator = None;
            self.abort(now_s, UNKNOWN, &error);
        } else {
            self.prepare_given();
        }
    }

    /// Transforms a goal of another frame, from before this map, to the frame of the map.
    fn transform_goal(&mut self, now_s: f64) -> Result<(), MessageError> {
        let Some((frame, goal)) = self.goal.clone() else {
            return Ok(());
        };
        let before = GoalInput { frame, stamp: Time::default(), goal };
        let GoalInput { frame, goal, .. } = self.in_map_frame(now_s, &before)?;
        if frame != before.frame {
            // It drives to the goal in the frame before.
            self.navigator = None;
            self.goal = Some((frame, goal));
        }
        Ok(())
    }

    /// The newest map with its zones, and with what scans contradicted for minutes; none while the masks cannot be used.
    pub(super) fn navigation_map(&self) -> Option<NavigationMap> {
        let map = self.inputs.map.as_ref().filter(|_| self.zones.missing().is_none())?;
        let config = &self.settings.config;
        let zones = self.zones.zones();
        let obstacles = if config.navigator.features.map_changes {
            self.contradicted.planned_with().applied_to(&map.grid).obstacles(config.unknown)
        } else {
            map.grid.obstacles(config.unknown)
        };
        Some(NavigationMap { obstacles, zones })
    }

    /// Looks at what scans contradict in the map, and plans with it where that is much. Returns the updated map when it has changed.
    pub(super) fn look_for_changes(&mut self, now_s: f64) -> Option<msg::OccupancyGrid> {
        let (localization, contradicted) = (&self.localization, &mut self.contradicted);
        let map = self.inputs.map.as_ref()?;
        let changes = || localization.as_ref()?.map_changes(&map.grid);
        let least_m = self.settings.config.robot.footprint.body_radius_m();
        let extent = (map.grid.frame(), least_m);
        let (changes, is_large) = contradicted.look(now_s, extent, changes)?;
        let is_used = self.settings.config.navigator.features.map_changes;
        if is_large {
            let use_of = if is_used { "consider" } else { "do not consider" };
            let [appeared, vanished] = changes.areas(map.grid.frame()).map(|areas| areas.len());
            self.notices.push(format!(
                "the scans contradict the map for a minute: obstacles appeared: {appeared}, vanished: {vanished}; the plans {use_of} that"
            ));
        }
        let header = Header { stamp: Time::from_seconds(now_s), frame_id: map.frame.clone() };
        let updated = convert::occupancy_grid(&changes.applied_to(&map.grid), header);
        self.prepare_if(is_large && is_used);
        Some(updated)
    }

    /// Makes the zones of the newest masks on the newest map.
    fn update_zones(&mut self) {
        if let Some(map) = &self.inputs.map {
            self.zones.update(map, self.settings.config.robot.limits.max_vel_x);
        }
    }

    /// Uses the newest masks, if a message has changed them.
    pub(super) fn use_masks(&mut self, is_new: bool) {
        if is_new {
            self.update_zones();
            self.prepare_given();
        }
    }

    /// Prepares the map for a navigator that drives, because a message has changed it or its zones.
    fn prepare_given(&mut self) {
        self.map_update.is_given = true;
        self.prepare_if(true);
    }

    /// Prepares the map for a navigator that drives, if it has changed.
    fn prepare_if(&mut self, is_new: bool) {
        if !is_new || self.navigator.is_none() || self.ended_s.is_some() {
            return;
        }
        self.goal_update.outdate();
        let map = self.navigation_map();
        if let Some(NavigationMap { obstacles, .. }) =
            map.as_ref().filter(|_| self.map_update.is_given)
        {
            let cell = obstacles.frame().cell_of(&self.pose.position());
            self.notices.place_on_map(cell.is_some_and(|cell| obstacles.is_blocked(cell)));
        }
        let is_started = map.is_some_and(|map| self.map_update.start(&map, &self.settings.config));
        if !is_started {
            self.navigator = None;
        }
    }

    /// Gives navigator and localizer a changed map that is prepared.
    pub(super) fn update_map(&mut self) {
        let mut map_update = std::mem::take(&mut self.map_update);
        let newest = || self.navigation_map();
        let taken = map_update.take(newest, &self.settings.config);
        self.map_update = map_update;
        match (taken, &mut self.navigator) {
            (Ok(Some(changed)), Some(navigator)) => {
                let is_given = self.map_update.is_given;
                let source = if is_given { MapSource::Given } else { MapSource::Scans };
                navigator.replace_map(changed.for_navigator, source);
                // A newer map that is in preparation was given too.
                self.map_update.is_given &= self.map_update.is_running();
                if let (Some(own), Some(map)) = (&mut self.localization, changed.for_localizer) {
                    own.adopt_changes(map);
                }
            }
            (Ok(_), _) => {}
            // The robot stops, and a new navigator plans.
            (Err(()), _) => self.navigator = None,
        }
    }
}
