//! The worlds that cells drive in. A digest of its content identifies a world, not its name.

use core::ops::Deref;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use serde_json::json;

use super::barn::{self, BarnWorld, Course};
use super::dynabarn::{self, DynaBarnWorld};
use super::localization::localization_config;
use super::missions::{MissionSite, Rules};
use super::{ExperimentError, LocalizationCase, LocalizationSite, RunRow, TrafficKind, WorldKind};
use crate::digest::BitDigest;
use crate::geometry::Pose;
use crate::map::{OccupancyGrid, Zones};
use crate::navigator::Goal;
use crate::runtime::{Config, Mission, MissionResult, check_start};
use crate::sim::{SimError, Simulation, draw_plant, first_path};

/// A world with the settings of its kind.
#[derive(Clone, Debug)]
pub struct World {
    /// Its kind.
    pub kind: WorldKind,
    /// Its name in tables.
    pub name: String,
    /// The settings before any change.
    pub settings: Arc<WorldSettings>,
    /// Whether latency is measured here.
    pub latency: bool,
    /// Ends the drives of this world at the next tick once it is set. It does not affect the world's identity.
    pub interrupt: Option<Arc<AtomicBool>>,
    pub(super) source: Arc<WorldSource>,
    pub(super) digest: String,
}

/// Settings with a digest of them. It is a part of the key of every cell in the world, and takes long to compute.
#[derive(Clone, Debug)]
pub struct WorldSettings {
    config: Config,
    pub(super) digest: String,
}

impl From<Config> for WorldSettings {
    fn from(config: Config) -> Self {
        let mut digest = BitDigest::default();
        digest.text(&json!(config).to_string());
        Self { config, digest: digest.hex() }
    }
}

impl Deref for WorldSettings {
    type Target = Config;

    fn deref(&self) -> &Config {
        &self.config
    }
}

/// The source of a world.
#[derive(Clone, Debug)]
pub(super) enum WorldSource {
    /// A world of BARN.
    Barn(BarnWorld),
    /// A world of `DynaBARN`.
    DynaBarn(DynaBarnWorld),
    /// A route on a map.
    Route(Route),
    /// A map, on which the seed determines a mission.
    Mission { map: Arc<OccupancyGrid>, rules: Rules },
    /// A case of the localization experiment.
    Localization { case: LocalizationCase, site: Arc<LocalizationSite> },
}

/// Time limit of a route, seconds: a fixed part to turn and to park, and a part for each metre of its path, a tenth of walking speed.
const ENDS_S: f64 = 30.0;
const SLOWEST_S_PER_M: f64 = 10.0;

/// A route on a map, among people.
#[derive(Clone, Debug)]
pub(super) struct Route {
    pub map: Arc<OccupancyGrid>,
    pub zones: Option<Arc<Zones>>,
    /// The true map, where it differs from that of the robot.
    pub truth: Option<Arc<OccupancyGrid>>,
    pub start: Pose,
    pub goal: Goal,
    pub people: usize,
    /// Whether the people yield, by their kind; none for what the settings say.
    pub traffic: Option<TrafficKind>,
    /// None for a time limit by the length of the path.
    pub time_limit_s: Option<f64>,
}

/// A simulation of a world, with the figures that the seed determines.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct WorldSimulation {
    /// The mission in its world.
    pub simulation: Simulation,
    /// Length of the first global path of a random mission or of a drive of the paper, metres.
    pub path_m: Option<f64>,
    /// Kind of its moving obstacles.
    pub traffic: Option<TrafficKind>,
    /// Number of obstacles on the path that the map does not show.
    pub unmapped: usize,
}

/// What the runs of all planners in a world with a seed are measured against.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reference {
    /// Length of the path, metres.
    pub path_m: f64,
    /// Time for it, seconds.
    pub time_s: f64,
}

impl World {
    fn new(kind: WorldKind, name: String, settings: Config, source: WorldSource) -> Self {
        Self {
            kind,
            name,
            settings: Arc::new(settings.into()),
            latency: false,
            interrupt: None,
            digest: source.digest(),
            source: Arc::new(source),
        }
    }

    /// A world of BARN, driven at up to this speed, m/s.
    #[must_use]
    pub fn barn(world: BarnWorld, max_speed_m_s: f64) -> Self {
        let (name, settings) = (world.number.to_string(), barn::barn_config(max_speed_m_s));
        Self::new(WorldKind::Barn, name, settings, WorldSource::Barn(world))
    }

    /// A world of `DynaBARN`.
    #[must_use]
    pub fn dynabarn(world: DynaBarnWorld) -> Self {
        let (name, settings) = (world.number.to_string(), dynabarn::dynabarn_config());
        let source = WorldSource::DynaBarn(world);
        Self::new(WorldKind::DynaBarn, name, settings, source)
    }

    /// A map for random missions.
    #[must_use]
    pub fn missions(name: &str, map: Arc<OccupancyGrid>, rules: Rules) -> Self {
        let source = WorldSource::Mission { map, rules };
        Self::new(WorldKind::Missions, name.to_owned(), Config::default(), source)
    }

    /// A case of the localization experiment.
    #[must_use]
    pub fn localization(case: LocalizationCase, site: &Arc<LocalizationSite>) -> Self {
        let name = format!("{} {}", site.world_name(case), case.name());
        let source = WorldSource::Localization { case, site: Arc::clone(site) };
        Self::new(WorldKind::Localization, name, localization_config(), source)
    }

    /// A route on a map, with this many people across its path. Without a time limit, in seconds, it is set by the length of the
    /// path.
    #[must_use]
    pub fn on_map(
        name: &str,
        map: Arc<OccupancyGrid>,
        zones: Option<Arc<Zones>>,
        start: Pose,
        goal: Goal,
        people: usize,
        time_limit_s: Option<f64>,
    ) -> Self {
        let route = Route { zones, people, time_limit_s, ..Route::new(map, start, goal) };
        Self::route(WorldKind::Map, name.to_owned(), route)
    }

    pub(super) fn route(kind: WorldKind, name: String, route: Route) -> Self {
        Self::new(kind, name, Config::default(), WorldSource::Route(route))
    }

    /// Rejects a route that no robot of some settings can drive: an end outside the map or in an obstacle, or a start without room
    /// for its yaw. It is an error of the plan, and no run that fails.
    pub(super) fn check_route(&self, config: &Config) -> Result<(), ExperimentError> {
        let WorldSource::Route(route) = self.source.as_ref() else {
            return Ok(());
        };
        let obstacles = route.map.obstacles(config.unknown);
        let unusable =
            |reason: String| ExperimentError::Unusable { place: self.name.clone(), reason };
        for (end, place) in [("start", route.start.position()), ("goal", route.goal.position)] {
            let why = match obstacles.frame().cell_of(&place) {
                None => "outside the map",
                Some(cell) if obstacles.is_blocked(cell) => "in an obstacle of the map",
                Some(_) => continue,
            };
            let (x, y) = (place.x, place.y);
            return Err(unusable(format!(
                "the {end} ({x:.2}, {y:.2}) of a route is {why}: move it"
            )));
        }
        check_start(&route.start, &obstacles, &config.robot.footprint)
            .map_err(|error| unusable(error.to_string()))
    }

    /// The row of a run before its start.
    pub(super) fn row(&self, config: &Config, engine: &str, seed: u64) -> RunRow {
        let (case, traffic) = match self.source.as_ref() {
            WorldSource::Localization { case, .. } => (Some(*case), None),
            WorldSource::Route(route) => (None, route.traffic),
            _ => (None, None),
        };
        RunRow {
            kind: self.kind,
            world: self.name.clone(),
            vx_samples: config.local.vx_samples,
            vtheta_samples: config.local.vtheta_samples,
            engine: engine.to_owned(),
            seed,
            latency: self.latency,
            case,
            traffic,
            ..RunRow::default()
        }
    }

    /// The reference of a run: BARN's own path at its fixed speed, elsewhere the first path of inbye's global planner at the highest
    /// speed, both with the world's own settings. Those of the run have no part in it: a slow robot would be measured against its own speed.
    /// Where the world's own robot has no path, the straight line to the first stop is the path.
    pub(super) fn reference(
        &self,
        mission: &Mission,
        config: &Config,
        result: &MissionResult,
    ) -> Reference {
        if let WorldSource::Barn(world) = self.source.as_ref() {
            let time_s = world.optimal_time_s;
            return Reference { path_m: time_s * barn::OPTIMAL_SPEED, time_s };
        }
        let own = || {
            let goal = mission.stops().first().copied().unwrap_or(mission.goal);
            let mission = Mission { goal, via: Vec::new(), ..mission.clone() };
            let straight_m = (goal.position - mission.start.position()).norm();
            first_path(&mission, &self.settings).map_or(straight_m, |path| path.length_m())
        };
        // A search of a large map takes long, and most runs have made it.
        let found = result.plans.first().filter(|_| plans_alike(config, &self.settings));
        let first_m = found.map_or_else(own, |plan| plan.smoothed.length_m());
        // A run may end before the goal itself.
        let path_m = first_m - mission.done_within_m.unwrap_or(0.0);
        Reference { path_m, time_s: path_m / self.settings.robot.limits.max_vel_x }
    }

    /// The simulation of a seed.
    ///
    /// # Errors
    /// [`ExperimentError`] when the world is too large for a grid, has no room for a mission, or an obstacle cannot move as
    /// described.
    pub fn simulation(
        &self,
        seed: u64,
        config: &Config,
    ) -> Result<WorldSimulation, ExperimentError> {
        let plain =
            |simulation| WorldSimulation { simulation, path_m: None, traffic: None, unmapped: 0 };
        Ok(match self.source.as_ref() {
            WorldSource::Barn(world) => plain(world.simulation(seed)?),
            WorldSource::DynaBarn(world) => plain(world.simulation(seed)?),
            WorldSource::Route(route) => route.simulation(seed, config)?,
            WorldSource::Mission { map, rules } => {
                let site = MissionSite::new(&self.name, OccupancyGrid::clone(map), config);
                site.generate(seed, rules, config)?
            }
            WorldSource::Localization { case, site } => {
                plain(site.simulation(*case, seed, config)?)
            }
        })
    }
}

/// Whether settings plan the first path of a mission as the settings of its world do, with inbye's global planner.
fn plans_alike(config: &Config, of_world: &Config) -> bool {
    !config.global_planner.is_set()
        && config.unknown == of_world.unknown
        && config.robot.footprint == of_world.robot.footprint
        && config.global == of_world.global
        && config.navigator == of_world.navigator
}

impl Route {
    /// A route without people, with a time limit by its length.
    pub const fn new(map: Arc<OccupancyGrid>, start: Pose, goal: Goal) -> Self {
        Self {
            map,
            zones: None,
            truth: None,
            start,
            goal,
            people: 0,
            traffic: None,
            time_limit_s: None,
        }
    }

    /// The simulation, with people spread along the path that the robot will plan.
    fn simulation(&self, seed: u64, config: &Config) -> Result<WorldSimulation, SimError> {
        let mut pedestrians = draw_plant(config, seed).pedestrians;
        if let Some(traffic) = self.traffic {
            pedestrians = pedestrians.yields(traffic != TrafficKind::NonYielding);
        }
        let spawner = pedestrians.spawner(self.people, seed);
        let mut mission = Mission {
            zones: self.zones.clone(),
            ..Mission::new(Arc::clone(&self.map), self.start, self.goal)
        };
        let moving_obstacles = spawner.spawn_on_route(&mission, config)?;
        let path_m = match self.time_limit_s {
            Some(_) => None,
            None => Some(first_path(&mission, config)?.length_m()),
        };
        let by_path_s = path_m.map(|path_m| ENDS_S + SLOWEST_S_PER_M * path_m);
        mission.time_limit_s = self.time_limit_s.or(by_path_s).unwrap_or_default();
        let truth = self.truth.as_ref().map(|truth| truth.obstacles(config.unknown));
        let simulation = Simulation { truth, moving_obstacles, seed, ..Simulation::new(mission) };
        Ok(WorldSimulation { simulation, path_m, traffic: self.traffic, unmapped: 0 })
    }
}

impl WorldSource {
    /// A digest of everything that affects a run in it.
    fn digest(&self) -> String {
        let mut digest = BitDigest::default();
        match self {
            Self::Barn(world) => add_barn(&mut digest, world),
            Self::DynaBarn(world) => add_dynabarn(&mut digest, world),
            Self::Route(route) => {
                digest.text("route");
                add_map(&mut digest, &route.map);
                if let Some(zones) = &route.zones {
                    digest.text("zones");
                    add_map(&mut digest, zones.grid());
                }
                if let Some(truth) = &route.truth {
                    digest.text("truth");
                    add_map(&mut digest, truth);
                }
                add_pose(&mut digest, &route.start);
                add(&mut digest, &[route.goal.position.x, route.goal.position.y]);
                add_optional(&mut digest, route.goal.yaw);
                digest.wide(route.people as u64);
                digest.text(route.traffic.map_or("", TrafficKind::name));
                add_optional(&mut digest, route.time_limit_s);
            }
            Self::Mission { map, rules } => {
                digest.text("mission");
                add_map(&mut digest, map);
                add(&mut digest, &[rules.min_m, rules.longest_m]);
                digest.wide(rules.max_people as u64);
                digest.real(rules.unmapped_share);
            }
            Self::Localization { case, site } => {
                digest.text("localization");
                digest.text(case.name());
                add_map(&mut digest, &site.map);
                add_pose(&mut digest, &site.start);
                add(&mut digest, &[site.goal.x, site.goal.y, site.tour_m]);
            }
        }
        digest.hex()
    }
}

fn add_barn(digest: &mut BitDigest, world: &BarnWorld) {
    let Course { start, goal, goal_radius_m, time_limit_s } = world.course;
    digest.text("barn");
    add_pose(digest, &start);
    add(digest, &[goal.x, goal.y, goal_radius_m, time_limit_s, world.optimal_time_s]);
    for cylinder in &world.cylinders {
        add(digest, &[cylinder.x_m, cylinder.y_m, cylinder.radius_m]);
    }
}

fn add_dynabarn(digest: &mut BitDigest, world: &DynaBarnWorld) {
    digest.text("dynabarn");
    add_pose(digest, &world.start);
    add(digest, &[world.goal.x, world.goal.y]);
    for cylinder in &world.cylinders {
        digest.real(cylinder.radius_m);
        add_optional(digest, cylinder.script.period_s());
        digest.wide(cylinder.script.keys().len() as u64);
        for (time_s, place) in cylinder.script.keys() {
            add(digest, &[*time_s, place.x, place.y]);
        }
    }
}

fn add_map(digest: &mut BitDigest, map: &OccupancyGrid) {
    let frame = map.frame();
    digest.wide(frame.width as u64);
    digest.real(frame.resolution_m);
    add_pose(digest, &frame.origin);
    for &cell in map.cells() {
        digest.word(u32::from(cell as u8));
    }
}

fn add_pose(digest: &mut BitDigest, pose: &Pose) {
    add(digest, &[pose.x, pose.y, pose.yaw]);
}

fn add_optional(digest: &mut BitDigest, number: Option<f64>) {
    digest.word(u32::from(number.is_some()));
    digest.real(number.unwrap_or_default());
}

fn add(digest: &mut BitDigest, numbers: &[f64]) {
    numbers.iter().for_each(|&number| digest.real(number));
}
