//! Changed maps for a navigator that drives.

use std::thread::{Builder, JoinHandle};

use super::Config;
use crate::localization::MapChanges;
use crate::navigator::{Fault, NavigationMap, PreparedMap};

/// Interval at which the scans' contradictions to the map are looked at, seconds.
const INTERVAL_S: f64 = 10.0;

/// What the scans contradict in a map, and when that was looked at, seconds.
#[derive(Debug)]
pub(crate) struct ContradictedMap {
    changes: Option<MapChanges>,
    looked_s: f64,
}

impl Default for ContradictedMap {
    fn default() -> Self {
        Self { changes: None, looked_s: f64::NEG_INFINITY }
    }
}

impl ContradictedMap {
    /// Looks at the changes if that is due. Returns them if they differ from those before.
    pub fn look(
        &mut self,
        now_s: f64,
        changes: impl FnOnce() -> Option<MapChanges>,
    ) -> Option<&MapChanges> {
        if (0.0..INTERVAL_S).contains(&(now_s - self.looked_s)) {
            return None;
        }
        self.looked_s = now_s;
        let changes = changes()?;
        let is_same = match &self.changes {
            Some(before) => *before == changes,
            None => changes.is_empty(),
        };
        if is_same {
            return None;
        }
        self.changes = Some(changes);
        self.changes.as_ref()
    }

    /// The changes at the last look.
    pub const fn changes(&self) -> Option<&MapChanges> {
        self.changes.as_ref()
    }
}

/// Prepares a map for a navigator with these settings.
///
/// # Errors
/// When the global planner or its thread does not start.
pub(crate) fn prepare(map: NavigationMap, config: &Config) -> Result<PreparedMap, Fault> {
    let route_planner = config.new_global_planner(map.obstacles.frame().resolution_m)?;
    PreparedMap::new(map, route_planner, &config.navigator)
}

/// The preparation of the newest map on a thread of its own, while the robot drives.
#[derive(Debug, Default)]
pub(crate) struct MapUpdate {
    running: Option<JoinHandle<Result<PreparedMap, Fault>>>,
    /// A newer map arrived since the start of the thread.
    is_outdated: bool,
}

impl MapUpdate {
    /// The map has changed. Returns false if no thread starts.
    pub fn start(&mut self, map: &NavigationMap, config: &Config) -> bool {
        if self.is_running() {
            self.is_outdated = true;
            return true;
        }
        let (map, config) = (map.clone(), config.clone());
        let prepare = move || prepare(map, &config);
        self.running = Builder::new().name("inbye-map".to_owned()).spawn(prepare).ok();
        self.is_outdated = false;
        self.is_running()
    }

    /// Whether a map is in preparation.
    pub const fn is_running(&self) -> bool {
        self.running.is_some()
    }

    /// The prepared map, once. With the error the robot must stop and start again on the newest map.
    pub fn take(
        &mut self,
        newest: impl FnOnce() -> Option<NavigationMap>,
        config: &Config,
    ) -> Result<Option<PreparedMap>, ()> {
        let Some(finished) = self.running.take_if(|running| running.is_finished()) else {
            return Ok(None);
        };
        let prepared = finished.join().ok().and_then(Result::ok).ok_or(())?;
        if self.is_outdated && !newest().is_some_and(|map| self.start(&map, config)) {
            return Err(());
        }
        Ok(Some(prepared))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::Cell;

    #[test]
    fn contradicted_map_returns_changes_once_and_looks_every_ten_seconds() {
        let changes = |columns: &[i32]| {
            let vanished = columns.iter().map(|&column| Cell::new(column, 0)).collect();
            Some(MapChanges { appeared: Vec::new(), vanished })
        };
        let mut map = ContradictedMap::default();
        assert_eq!(map.look(0.0, || changes(&[])), None);
        assert_eq!(map.look(9.9, || panic!("not due")), None);
        assert_eq!(map.look(10.0, || changes(&[3])), changes(&[3]).as_ref());
        assert_eq!(map.look(20.0, || changes(&[3])), None);
        assert_eq!(map.look(30.0, || None), None);
        assert_eq!(map.changes(), changes(&[3]).as_ref());
        assert_eq!(map.look(40.0, || changes(&[])), changes(&[]).as_ref());
    }
}
