//! A scene and its missions.

use core::f64::consts::FRAC_PI_4;
use std::sync::Arc;

use crate::bench::paper::{PaperError, Site};
use crate::experiment::TrafficKind;
use crate::geometry::{Point, Pose};
use crate::global::Plan;
use crate::map::{ObstacleGrid, OccupancyGrid};
use crate::navigator::{Goal, Route};
use crate::runtime::{Config, Mission};
use crate::sim::{MovingObstacles, Simulation};

/// Yaw at the start, radians: the paper's initial direction angle.
pub const START_YAW_RAD: f64 = FRAC_PI_4;
/// Yaw at the goal, radians. The paper measures a yaw deviation but not its reference; this is the start yaw.
pub const GOAL_YAW_RAD: f64 = FRAC_PI_4;
/// Time limit for each metre of the path, seconds: a tenth of walking speed.
const SLOWEST_S_PER_M: f64 = 10.0;

/// A scene with one task, and its number of people in fig. 13.
#[derive(Clone, Debug)]
pub struct Course {
    /// Name of the site.
    pub name: String,
    /// Title.
    pub title: String,
    /// The map.
    pub map: Arc<OccupancyGrid>,
    /// Pose at the start, where the robot stands still.
    pub start: Pose,
    /// The goal.
    pub goal: Goal,
    /// The first global path.
    pub plan: Plan,
    /// The key nodes of that path: the local targets.
    pub key_nodes: Vec<Point>,
    /// Number of people in drives with people.
    pub people: usize,
    obstacles: ObstacleGrid,
}

impl Course {
    /// The first task of a site, with this number of people.
    ///
    /// # Errors
    /// [`PaperError::NoPath`] when the configuration's robot has no path.
    pub fn new(site: &Site, people: usize, config: &Config) -> Result<Self, PaperError> {
        let frame = site.map.frame();
        let mut planner = config.route_planner(frame.resolution_m);
        let no_path =
            || PaperError::NoPath { task: site.name.clone(), radius_m: site.proof.radius_m() };
        let task = site.tasks.first().ok_or_else(no_path)?;
        let [start, goal] = [task.start, task.goal].map(|end| frame.center_of(end));
        let plan =
            planner.plan(&site.obstacles, start, goal, &mut || 0.0).map_err(|_| no_path())?;
        let route = Route::new(&plan, &config.navigator);
        Ok(Self {
            name: site.name.clone(),
            title: site.title.clone(),
            map: Arc::new(site.map.clone()),
            start: Pose::new(start.x, start.y, START_YAW_RAD),
            goal: Goal { position: goal, yaw: Some(GOAL_YAW_RAD) },
            key_nodes: route.key_nodes().collect(),
            plan,
            people,
            obstacles: site.obstacles.clone(),
        })
    }

    /// The first task of each site: one person in the first site, two in the second, and so on, as in fig. 13.
    ///
    /// # Errors
    /// As [`Course::new`].
    pub fn all(sites: &[Site], config: &Config) -> Result<Vec<Self>, PaperError> {
        let courses = sites.iter().enumerate();
        courses.map(|(index, site)| Self::new(site, index + 1, config)).collect()
    }

    /// The simulation of a seed, which determines the people and the noise of the simulation.
    ///
    /// # Errors
    /// [`PaperError::Drive`] when the people have no room.
    pub fn simulation(
        &self,
        traffic: TrafficKind,
        seed: u64,
        config: &Config,
    ) -> Result<Simulation, PaperError> {
        let moving_obstacles = self.moving_obstacles(traffic, seed, config)?;
        Ok(Simulation {
            moving_obstacles,
            seed,
            ..Simulation::new(Mission {
                time_limit_s: SLOWEST_S_PER_M * self.plan.smoothed.length_m(),
                ..Mission::new(Arc::clone(&self.map), self.start, self.goal)
            })
        })
    }

    fn moving_obstacles(
        &self,
        traffic: TrafficKind,
        seed: u64,
        config: &Config,
    ) -> Result<MovingObstacles, PaperError> {
        let yields = match traffic {
            TrafficKind::None => return Ok(MovingObstacles::default()),
            TrafficKind::NonYielding => false,
            TrafficKind::Yielding | TrafficKind::Appearing => true,
        };
        let pedestrians = config.simulation.pedestrians.yielding(yields);
        let spawner = pedestrians.spawner(self.people, seed);
        let path = self.plan.smoothed.points();
        let keep_clear = [self.start.position(), self.goal.position];
        spawner.spawn(&self.obstacles, path, &keep_clear).map_err(|error| self.failed(seed, &error))
    }

    /// The error of a drive that cannot start.
    pub(super) fn failed(&self, seed: u64, reason: &dyn core::fmt::Display) -> PaperError {
        PaperError::Drive { scene: self.name.clone(), seed, reason: reason.to_string() }
    }
}
