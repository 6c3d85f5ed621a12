//! A map for random missions, and the mission of a seed.

use core::f64::consts::PI;
use std::sync::Arc;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::Rules;
use super::traffic::traffic;
use super::unmapped::add_unmapped;
use crate::experiment::{ExperimentError, WorldSimulation};
use crate::geometry::{Point, Pose};
use crate::global::Plan;
use crate::map::{Cell, FreeSpace, ObstacleGrid, OccupancyGrid};
use crate::navigator::{Goal, RoutePlanner};
use crate::runtime::{Config, Mission};
use crate::sim::{Simulation, draw_plant};

/// Attempts to find a start that has a goal. A start in a small enclosed area has none.
const ATTEMPTS: usize = 200;
/// Time limit, seconds: a fixed part, and a part for each metre of the path. The default robot drives up to 1 m/s; the rest is
/// for waiting, detours and one more attempt shortly before the navigator gives up (after 90 s by default).
const TIME_S: f64 = 180.0;
const TIME_S_PER_M: f64 = 6.0;

/// A map, and its free cells for the robot's origin.
#[derive(Clone, Debug)]
pub struct MissionSite {
    /// Its name in rows and messages.
    pub name: String,
    /// The map that the robot has.
    pub map: Arc<OccupancyGrid>,
    /// Its obstacles.
    pub obstacles: ObstacleGrid,
    /// Cells at least as far from every obstacle as a global path must be.
    pub free: FreeSpace,
    /// Indices of the free cells, ascending.
    free_cells: Vec<usize>,
}

impl MissionSite {
    /// A map for the robot of a configuration.
    #[must_use]
    pub fn new(name: &str, map: OccupancyGrid, config: &Config) -> Self {
        let obstacles = map.obstacles(config.unknown);
        let planner = config.route_planner(map.frame().resolution_m);
        let free = FreeSpace::new(&obstacles, planner.least_radius_m());
        let frame = *free.frame();
        let free_cells: Vec<usize> = frame
            .cells()
            .filter(|&cell| free.is_free(cell))
            .map(|cell| frame.index(cell))
            .collect();
        Self { name: name.to_owned(), map: Arc::new(map), obstacles, free, free_cells }
    }

    /// Generates the mission of a seed: start and goal in free space, joined by a path of the planner within the rules'
    /// lengths; both yaws are uniformly random.
    ///
    /// # Errors
    /// Fails when the map has no room, or a rule is out of range.
    pub fn generate(
        &self,
        seed: u64,
        rules: &Rules,
        config: &Config,
    ) -> Result<WorldSimulation, ExperimentError> {
        rules.validate()?;
        // The same missions whether or not the robot drives through narrow passages.
        let mut settings = config.clone();
        settings.navigator.features.narrow_passages = false;
        let mut planner = settings.route_planner(self.map.frame().resolution_m);
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        let (start, goal, plan) = self.ends(rules, &mut planner, &mut rng)?;
        let path = &plan.smoothed;
        let yaw = |rng: &mut Pcg64Mcg| rng.random_range(-PI..PI);
        let (start_yaw, goal_yaw) = (yaw(&mut rng), yaw(&mut rng));
        // All random numbers are drawn under any rules: a seed has the same ends and obstacles under other rules.
        let mut own = Pcg64Mcg::seed_from_u64(rng.random());
        let is_wrong = own.random::<f64>() < rules.unmapped_share;
        let (truth, unmapped) = if is_wrong {
            add_unmapped(&self.obstacles, path, &mut planner, &mut own)
        } else {
            (self.obstacles.clone(), 0)
        };
        let pedestrians = draw_plant(config, seed).pedestrians;
        let robot_m = config.robot.footprint.circumscribed_radius_m();
        let (traffic, moving_obstacles) =
            traffic(rules, pedestrians, (&truth, path), robot_m, &mut rng);
        let path_m = path.length_m();
        let goal = Goal { position: goal, yaw: Some(goal_yaw) };
        let start = Pose::new(start.x, start.y, start_yaw);
        let simulation = Simulation {
            truth: (unmapped > 0).then_some(truth),
            moving_obstacles,
            seed,
            ..Simulation::new(Mission {
                time_limit_s: TIME_S + TIME_S_PER_M * path_m,
                ..Mission::new(Arc::clone(&self.map), start, goal)
            })
        };
        Ok(WorldSimulation { simulation, path_m: Some(path_m), traffic: Some(traffic), unmapped })
    }

    fn ends(
        &self,
        rules: &Rules,
        planner: &mut RoutePlanner,
        rng: &mut Pcg64Mcg,
    ) -> Result<(Point, Point, Plan), ExperimentError> {
        let frame = *self.free.frame();
        let most_moves = (rules.longest_m / frame.resolution_m) as u32;
        let attempts = if self.free_cells.is_empty() { 0 } else { ATTEMPTS };
        for _ in 0..attempts {
            let first = frame.cell_at(self.free_cells[rng.random_range(0..self.free_cells.len())]);
            let start = frame.center_of(first);
            let is_usable = |&cell: &Cell| {
                let is_inner = self.free_cells.binary_search(&frame.index(cell)).is_ok();
                is_inner && (frame.center_of(cell) - start).norm() >= rules.min_m
            };
            let mut seen = vec![false; frame.len()];
            let reached = self.free.flood(first, &mut seen);
            let reached = reached.take_while(|&(_, moves)| moves <= most_moves);
            let reached: Vec<Cell> = reached.map(|(cell, _)| cell).filter(is_usable).collect();
            if reached.is_empty() {
                continue;
            }
            let goal = frame.center_of(reached[rng.random_range(0..reached.len())]);
            let plan = planner.plan(&self.obstacles, start, goal, &mut || 0.0);
            if let Some(plan) = plan
                .ok()
                .filter(|plan| (rules.min_m..=rules.longest_m).contains(&plan.smoothed.length_m()))
            {
                return Ok((start, goal, plan));
            }
        }
        let (min_m, longest_m, radius_m) = (rules.min_m, rules.longest_m, self.free.radius_m());
        Err(ExperimentError::Unusable {
            place: self.name.clone(),
            reason: format!(
                "no two free places {min_m} to {longest_m} m apart along a path were found for a radius of {radius_m:.3} m: \
                 use a larger map or shorter missions"
            ),
        })
    }
}
