//! The worlds that a plan names, read from their files.

use std::path::Path;
use std::sync::Arc;

use super::missions::Rules;
use super::paper_drives::{Course, drive_worlds};
use super::world::Route;
use super::{
    ExperimentError, LocalizationCase, LocalizationSite, Plan, PlanRoute, PlanWorlds, World,
    WorldKind, barn, dynabarn, mrpb,
};
use crate::bench::paper::{Site, made_mine};
use crate::geometry::{Point, Pose};
use crate::map::{LoadOptions, OccupancyGrid, load};
use crate::navigator::Goal;
use crate::runtime::Config;
use crate::sim::{Scene, roadway, scenes};

/// Seed of the generated mine.
const MINE_SEED: u64 = 1;
/// Number of worlds that an error names.
const NAMED: usize = 5;
/// Smallest length of a tour of localization, metres.
const TOUR_M: f64 = 300.0;

impl Plan {
    /// Reads all worlds of the plan, in its order, with its changes of their settings. Paths are relative to this folder.
    ///
    /// # Errors
    /// Fails when a world cannot be read, or the changes do not fit its settings.
    pub fn read_worlds(&self, folder: &Path) -> Result<Vec<World>, ExperimentError> {
        let mut all = Vec::new();
        for group in &self.worlds {
            let latency = group.latency;
            for world in of_group(group, folder)? {
                let mut world = World { latency, ..world };
                if !self.config.0.is_empty() {
                    let settings = self.config.applied("config", &world.settings)?;
                    world.settings = Arc::new(settings.into());
                }
                all.push(world);
            }
        }
        Ok(all)
    }
}

fn of_group(group: &PlanWorlds, folder: &Path) -> Result<Vec<World>, ExperimentError> {
    let path = group.path.as_ref().map(|path| folder.join(path));
    let path = path.unwrap_or_else(|| folder.to_owned());
    let only = (!group.only.is_empty()).then_some(group.only.as_slice());
    let speed_m_s = group.max_speed_m_s;
    Ok(match group.kind {
        WorldKind::Barn => barn::read_worlds(&path, only)?
            .into_iter()
            .map(|world| World::barn(world, speed_m_s))
            .collect(),
        WorldKind::DynaBarn => {
            dynabarn::read_worlds(&path, only)?.into_iter().map(World::dynabarn).collect()
        }
        WorldKind::Scenes => {
            scenes().into_iter().map(|scene| of_scene(scene, group.time_limit_s)).collect()
        }
        WorldKind::Map => routes(group, &path)?,
        WorldKind::Mrpb => mrpb::read_worlds(&path, group.people)?,
        WorldKind::Localization => {
            let site = Arc::new(LocalizationSite::of_scene(roadway(), TOUR_M));
            LocalizationCase::ALL.map(|case| World::localization(case, &site)).to_vec()
        }
        WorldKind::Paper => {
            let config = Config::default();
            drive_worlds(&Course::all(&Site::roadways(&config), &config)?)
        }
        WorldKind::Missions => {
            let rules = Rules {
                longest_m: group.longest_m,
                max_people: group.people,
                unmapped_share: group.unmapped_share,
                ..Rules::default()
            };
            if group.path.is_some() {
                let (name, map) = map(group, &path)?;
                vec![World::missions(&name, map, rules)]
            } else {
                built_in_maps(rules)
            }
        }
    })
}

fn of_scene(scene: Scene, time_limit_s: f64) -> World {
    let goal = Goal::at(scene.goal);
    let route = Route {
        people: scene.obstacles,
        time_limit_s: Some(time_limit_s),
        ..Route::new(Arc::new(scene.map), scene.start, goal)
    };
    World::route(WorldKind::Scenes, scene.name.to_owned(), route)
}

fn routes(group: &PlanWorlds, path: &Path) -> Result<Vec<World>, ExperimentError> {
    let (name, map) = map(group, path)?;
    let route = |(index, route): (usize, &PlanRoute)| {
        let position = Point::new(route.goal[0], route.goal[1]);
        let goal = Goal { position, yaw: route.goal.get(2).copied() };
        let route = Route {
            people: group.people,
            time_limit_s: Some(group.time_limit_s),
            ..Route::new(Arc::clone(&map), Pose::from(route.start), goal)
        };
        World::route(WorldKind::Map, format!("{name} route {}", index + 1), route)
    };
    Ok(group.routes.iter().enumerate().map(route).collect())
}

/// The maps of the built-in scenes and the generated mine, for random missions.
#[must_use]
pub fn built_in_maps(rules: Rules) -> Vec<World> {
    let scenes = scenes().into_iter().map(|scene| (scene.name, scene.map));
    scenes
        .chain([("made_mine", made_mine(MINE_SEED))])
        .map(|(name, map)| World::missions(name, Arc::new(map), rules))
        .collect()
}

fn map(group: &PlanWorlds, path: &Path) -> Result<(String, Arc<OccupancyGrid>), ExperimentError> {
    let options = LoadOptions { resolution_m: group.resolution_m };
    let map = load(path, &options)?;
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    Ok((name.into_owned(), Arc::new(map)))
}

/// Keeps the worlds with these numbers; all, if no number is given. `place` is their file or folder.
pub(super) fn select_worlds<W>(
    worlds: &mut Vec<W>,
    number: impl Fn(&W) -> u32,
    only: Option<&[u32]>,
    place: &Path,
) -> Result<(), ExperimentError> {
    let Some(only) = only else {
        return Ok(());
    };
    let absent = |asked: &&u32| worlds.iter().all(|world| number(world) != **asked);
    if let Some(world) = only.iter().find(absent) {
        let numbers = worlds.iter().map(|world| number(world).to_string());
        let (count, some) = (worlds.len(), numbers.take(NAMED).collect::<Vec<_>>().join(", "));
        let reason =
            format!("world {world} is not among the {count} here: it has {some} and others");
        return Err(ExperimentError::file(place, reason));
    }
    worlds.retain(|world| only.contains(&number(world)));
    Ok(())
}
