//! Prepares a changed map on a thread of its own while the robot drives.

use std::thread::{Builder, JoinHandle};

use crate::navigator::{Fault, NavigationMap, PreparedMap};
use crate::runtime::Config;

/// The preparation of the newest map.
#[derive(Debug, Default)]
pub struct MapUpdate {
    running: Option<JoinHandle<Result<PreparedMap, Fault>>>,
    /// A newer map arrived since the start of the thread.
    is_outdated: bool,
}

impl MapUpdate {
    /// The map has changed. Returns false if no thread starts.
    pub fn start(&mut self, map: &NavigationMap, config: &Config) -> bool {
        if self.running.is_some() {
            self.is_outdated = true;
            return true;
        }
        let (map, config) = (map.clone(), config.clone());
        let prepare = move || {
            let resolution_m = map.obstacles.frame().resolution_m;
            let route_planner = config.new_global_planner(resolution_m)?;
            PreparedMap::new(map, route_planner, &config.navigator)
        };
        self.running = Builder::new().name("inbye-map".to_owned()).spawn(prepare).ok();
        self.is_outdated = false;
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
