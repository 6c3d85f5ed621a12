//! The worlds that a plan names, read from their files.

use std::path::Path;
use std::sync::Arc;

use super::ground::Ground;
use super::{SweepError, SweepPlan, SweepWorlds, WorldKind};
use crate::bench::paper::made_mine;
use crate::experiment::missions::Rules;
use crate::experiment::{barn, dynabarn};
use crate::geometry::{Point, Pose};
use crate::map::{LoadOptions, OccupancyGrid, load};
use crate::navigator::Goal;
use crate::runtime::Config;
use crate::sim::scenes;

/// Seed of the made mine.
const MINE_SEED: u64 = 1;

/// A world, and what goes with it.
#[derive(Clone, Debug)]
pub(super) struct SweepWorld {
    pub kind: WorldKind,
    /// What it is called in tables.
    pub name: String,
    pub ground: Arc<Ground>,
    pub digest: String,
    /// The settings before any change.
    pub settings: Arc<Config>,
    pub latency: bool,
}

/// All worlds of a plan, in its order. Paths count from this folder on.
pub(super) fn worlds(plan: &SweepPlan, folder: &Path) -> Result<Vec<SweepWorld>, SweepError> {
    let mut all = Vec::new();
    for group in &plan.worlds {
        let settings = Arc::new(match group.kind {
            WorldKind::Barn => barn::barn_config(group.max_speed_m_s),
            WorldKind::DynaBarn => dynabarn::dynabarn_config(),
            WorldKind::Scenes | WorldKind::Map | WorldKind::Missions => Config::default(),
        });
        for (name, ground) in grounds(group, folder)? {
            all.push(SweepWorld {
                kind: group.kind,
                name,
                digest: ground.digest(),
                ground: Arc::new(ground),
                settings: Arc::clone(&settings),
                latency: group.latency,
            });
        }
    }
    Ok(all)
}

fn grounds(group: &SweepWorlds, folder: &Path) -> Result<Vec<(String, Ground)>, SweepError> {
    let path = group.path.as_ref().map(|path| folder.join(path));
    let path = path.unwrap_or_else(|| folder.to_owned());
    let only = (!group.only.is_empty()).then_some(group.only.as_slice());
    Ok(match group.kind {
        WorldKind::Barn => barn::read_worlds(&path, only)?
            .into_iter()
            .map(|world| (world.number.to_string(), Ground::Barn(world)))
            .collect(),
        WorldKind::DynaBarn => dynabarn::read_worlds(&path, only)?
            .into_iter()
            .map(|world| (world.number.to_string(), Ground::DynaBarn(world)))
            .collect(),
        WorldKind::Scenes => built_in(group),
        WorldKind::Map => routes(group, &path)?,
        WorldKind::Missions => missions(group, &path)?,
    })
}

fn built_in(group: &SweepWorlds) -> Vec<(String, Ground)> {
    let scene = |scene: crate::sim::Scene| {
        let ground = Ground::Route {
            map: Arc::new(scene.map),
            start: scene.start,
            goal: Goal {
                position: scene.goal,
                yaw: None,
            },
            people: scene.obstacles,
            time_limit_s: group.time_limit_s,
        };
        (scene.name.to_owned(), ground)
    };
    scenes().into_iter().map(scene).collect()
}

fn routes(group: &SweepWorlds, path: &Path) -> Result<Vec<(String, Ground)>, SweepError> {
    let (name, map) = map(group, path)?;
    let route = |(index, route): (usize, &super::Route)| {
        let ground = Ground::Route {
            map: Arc::clone(&map),
            start: Pose::from(route.start),
            goal: Goal {
                position: Point::new(route.goal[0], route.goal[1]),
                yaw: route.goal.get(2).copied(),
            },
            people: group.people,
            time_limit_s: group.time_limit_s,
        };
        (format!("{name} route {}", index + 1), ground)
    };
    Ok(group.routes.iter().enumerate().map(route).collect())
}

fn missions(group: &SweepWorlds, path: &Path) -> Result<Vec<(String, Ground)>, SweepError> {
    let rules = Rules {
        longest_m: group.longest_m,
        most_people: group.people,
        unmapped_share: group.unmapped_share,
        ..Rules::default()
    };
    let maps = if group.path.is_some() {
        vec![map(group, path)?]
    } else {
        let scenes = scenes().into_iter().map(|scene| (scene.name, scene.map));
        scenes
            .chain([("made_mine", made_mine(MINE_SEED))])
            .map(|(name, map)| (name.to_owned(), Arc::new(map)))
            .collect()
    };
    let mission = |(name, map)| (name, Ground::Mission { map, rules });
    Ok(maps.into_iter().map(mission).collect())
}

fn map(group: &SweepWorlds, path: &Path) -> Result<(String, Arc<OccupancyGrid>), SweepError> {
    let options = LoadOptions {
        resolution_m: group.resolution_m,
    };
    let map = load(path, &options)?;
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    Ok((name.into_owned(), Arc::new(map)))
}
