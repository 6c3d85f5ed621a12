//! Changed maps for a robot that drives.

use super::preparation::Preparation;
use super::{Config, PoseSource};
use crate::localization::{MapChanges, SignedDistanceField};
use crate::map::GridFrame;
use crate::navigator::{Fault, NavigationMap, PreparedMap};

/// Interval at which the changes of the map are checked, seconds.
const INTERVAL_S: f64 = 10.0;

/// The changes of a map that scans have shown.
#[derive(Debug)]
pub(crate) struct ContradictedMap {
    newest: MapChanges,
    /// The changes that the navigator's map contains.
    planned_with: MapChanges,
    /// Time of the last check, seconds.
    looked_s: f64,
}

impl Default for ContradictedMap {
    fn default() -> Self {
        let none = MapChanges::default();
        Self { newest: none.clone(), planned_with: none, looked_s: f64::NEG_INFINITY }
    }
}

impl ContradictedMap {
    /// Checks the changes on a grid if a check is due. Returns them if they differ from those of the last check, and whether to plan
    /// with them: an area in which they differ from the navigator's map is at least this long, metres. Each new map requires a new
    /// plan, and a change of single cells at a wall does not justify one.
    pub fn look(
        &mut self,
        now_s: f64,
        (frame, least_m): (&GridFrame, f64),
        changes: impl FnOnce() -> Option<MapChanges>,
    ) -> Option<(&MapChanges, bool)> {
        if (0.0..INTERVAL_S).contains(&(now_s - self.looked_s)) {
            return None;
        }
        self.looked_s = now_s;
        let changes = changes()?;
        if changes == self.newest {
            return None;
        }
        let is_large = self.planned_with.largest_difference_m(&changes, frame) >= least_m;
        if is_large {
            self.planned_with.clone_from(&changes);
        }
        self.newest = changes;
        Some((&self.newest, is_large))
    }

    /// The changes to plan with.
    #[cfg(any(test, feature = "ros"))]
    pub const fn planned_with(&self) -> &MapChanges {
        &self.planned_with
    }
}

/// A changed map, prepared for navigation and localisation.
pub(crate) struct ChangedMap {
    pub for_navigator: PreparedMap,
    /// `None` without a localizer.
    pub for_localizer: Option<SignedDistanceField>,
}

impl ChangedMap {
    /// # Errors
    /// When the global planner or its thread does not start.
    pub fn new(map: NavigationMap, config: &Config) -> Result<Self, Fault> {
        let is_localized = config.pose_source == PoseSource::Scans;
        let for_localizer = is_localized.then(|| SignedDistanceField::new(&map.obstacles));
        Ok(Self { for_navigator: config.prepare_map(map)?, for_localizer })
    }
}

/// The preparation of the newest map on its own thread, while the robot drives.
#[derive(Default)]
pub(crate) struct MapUpdate {
    preparation: Preparation<Result<ChangedMap, Fault>>,
    /// The map is not only changed by the robot's own scans.
    #[cfg(feature = "ros")]
    pub is_given: bool,
}

impl MapUpdate {
    /// The map has changed. Returns false if no thread starts.
    pub fn start(&mut self, map: &NavigationMap, config: &Config) -> bool {
        self.preparation.start("inbye-map", || {
            let (map, config) = (map.clone(), config.clone());
            move || ChangedMap::new(map, &config)
        })
    }

    /// Whether a map is in preparation.
    pub const fn is_running(&self) -> bool {
        self.preparation.is_running()
    }

    /// The prepared map, once. With the error the robot must stop and start again on the newest map.
    pub fn take(
        &mut self,
        newest: impl FnOnce() -> Option<NavigationMap>,
        config: &Config,
    ) -> Result<Option<ChangedMap>, ()> {
        let Some((prepared, is_outdated)) = self.preparation.take() else {
            return Ok(None);
        };
        let prepared = prepared.and_then(Result::ok).ok_or(())?;
        if is_outdated && !newest().is_some_and(|map| self.start(&map, config)) {
            return Err(());
        }
        Ok(Some(prepared))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::ops::Range;

    use crate::geometry::Pose;
    use crate::map::Cell;

    #[test]
    fn contradicted_map_plans_with_large_changes_and_looks_every_ten_seconds() {
        let frame = GridFrame::new(20, 1, 0.1, Pose::default()).expect("a frame");
        let changes = |columns: Range<i32>| {
            let vanished = columns.map(|column| Cell::new(column, 0)).collect();
            Some(MapChanges { appeared: Vec::new(), vanished })
        };
        let mut map = ContradictedMap::default();
        let mut look = |now_s, changes| {
            let looked = map.look(now_s, (&frame, 0.35), || changes);
            let is_large = looked.map(|(_, is_large)| is_large);
            (is_large, Some(map.planned_with().clone()))
        };
        assert_eq!(look(0.0, changes(0..0)), (None, changes(0..0)));
        assert_eq!(look(9.9, changes(0..9)), (None, changes(0..0)), "not due");
        assert_eq!(look(10.0, changes(3..6)), (Some(false), changes(0..0)), "too small");
        assert_eq!(
            look(20.0, changes(3..7)),
            (Some(true), changes(3..7)),
            "with what was left out"
        );
        assert_eq!(look(30.0, changes(3..7)), (None, changes(3..7)), "the same");
        assert_eq!(
            look(40.0, changes(1..9)),
            (Some(false), changes(3..7)),
            "two more on each side"
        );
        assert_eq!(look(50.0, None), (None, changes(3..7)));
        assert_eq!(look(60.0, changes(3..12)), (Some(true), changes(3..12)));
        assert_eq!(look(70.0, changes(0..0)), (Some(true), changes(0..0)));
    }
}
