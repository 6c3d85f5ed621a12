//! Maps that need no file.

use super::MissionSite;
use crate::bench::paper::made_mine;
use crate::runtime::Config;
use crate::sim::scenes;

/// Seed of the made mine.
const MINE_SEED: u64 = 1;

/// The built-in scenes and the made mine, for the robot of a configuration.
#[must_use]
pub fn built_in_sites(config: &Config) -> Vec<MissionSite> {
    let scenes = scenes().into_iter().map(|scene| (scene.name, scene.map));
    scenes
        .chain([("made_mine", made_mine(MINE_SEED))])
        .map(|(name, map)| MissionSite::new(name, map, config))
        .collect()
}
