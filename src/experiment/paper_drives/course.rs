//! A scene and its missions.

use core::f64::consts::FRAC_PI_4;
use std::sync::Arc;

use crate::bench::paper::{PaperError, Site};
use crate::experiment::world::Route;
use crate::experiment::{TrafficKind, World, WorldKind};
use crate::geometry::{Point, Pose};
use crate::global::Plan;
use crate::map::OccupancyGrid;
use crate::navigator;
use crate::navigator::Goal;
use crate::runtime::Config;

/// Yaw at the start, radians: the paper's initial direction angle.
const START_YAW_RAD: f64 = FRAC_PI_4;
/// Yaw at the goal, radians. The paper measures a yaw deviation but not its reference; this is the start yaw.
const GOAL_YAW_RAD: f64 = FRAC_PI_4;
/// The kinds of traffic, in the order of the tables.
pub const TRAFFIC: [TrafficKind; 3] =
    [TrafficKind::None, TrafficKind::Yielding, TrafficKind::NonYielding];

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
}

impl Course {
    /// The first task of each site: one person in the first site, two in the second, and so on, as in fig. 13.
    ///
    /// # Errors
    /// [`PaperError::NoPath`] when the configuration's robot has no path.
    pub fn all(sites: &[Site], config: &Config) -> Result<Vec<Self>, PaperError> {
        let courses = sites.iter().zip(1..);
        courses.map(|(site, people)| Self::new(site, people, config)).collect()
    }

    fn new(site: &Site, people: usize, config: &Config) -> Result<Self, PaperError> {
        let frame = site.map.frame();
        let mut planner = config.route_planner(frame.resolution_m);
        let no_path =
            || PaperError::NoPath { task: site.name.clone(), radius_m: site.proof.radius_m() };
        let task = site.tasks.first().ok_or_else(no_path)?;
        let [start, goal] = [task.start, task.goal].map(|end| frame.center_of(end));
        let plan =
            planner.plan(&site.obstacles, start, goal, &mut || 0.0).map_err(|_| no_path())?;
        let route = navigator::Route::new(&plan, &config.navigator);
        Ok(Self {
            name: site.name.clone(),
            title: site.title.clone(),
            map: Arc::new(site.map.clone()),
            start: Pose::new(start.x, start.y, START_YAW_RAD),
            goal: Goal { position: goal, yaw: Some(GOAL_YAW_RAD) },
            key_nodes: route.key_nodes().collect(),
            plan,
            people,
        })
    }

    /// The course with people of a kind. The seed of a run determines the people and the noise of the simulation.
    #[must_use]
    pub fn world(&self, traffic: TrafficKind) -> World {
        let route = Route {
            people: if traffic == TrafficKind::None { 0 } else { self.people },
            traffic: Some(traffic),
            ..Route::new(Arc::clone(&self.map), self.start, self.goal)
        };
        World::route(WorldKind::Paper, format!("{} {}", self.name, traffic.name()), route)
    }
}

/// All courses with each kind of traffic, in the order of the tables.
#[must_use]
pub fn drive_worlds(courses: &[Course]) -> Vec<World> {
    let of_traffic = |traffic| courses.iter().map(move |course| course.world(traffic));
    TRAFFIC.into_iter().flat_map(of_traffic).collect()
}
