//! Spawns pedestrians along the robot's route.

use core::f64::consts::{FRAC_PI_2, TAU};

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::moving_obstacle::Patrol;
use super::route_sampler::{straight_route, winding_route};
use super::{MovingObstacle, MovingObstacles, PedestrianSettings, SimError};
use crate::geometry::{Point, bearing};
use crate::global::Path;
use crate::map::{FreeSpace, ObstacleGrid};
use crate::navigator::Fault;
use crate::runtime::{Config, Mission, MissionError};
use crate::settings::require;

/// Shortest and longest walk, metres.
const WALK_M: core::ops::RangeInclusive<f64> = 4.0..=12.0;

/// Smallest distance of walks from the points to keep clear, metres, and of pedestrians from a robot that stands there.
const KEEP_CLEAR_M: f64 = 5.0;
const LEAST_GAP_M: f64 = 0.3;

/// Most pedestrians of a spawner.
const MAX_COUNT: usize = 100_000;

/// Attempts to find a walk for each pedestrian; after half of them the walk may be on any part of the path.
const ATTEMPTS: usize = 64;

/// Deviations of a crossing walk from perpendicular to the path, radians, in the order of the attempts.
const SLANTS_RAD: [f64; 7] = [0.0, 0.25, -0.25, 0.5, -0.5, 0.75, -0.75];

/// Number and properties of the pedestrians to spawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PedestrianSpawner {
    /// Number of pedestrians, at most 100 000.
    pub count: usize,
    /// Seed; the same seed gives the same pedestrians.
    pub seed: u64,
    /// Size, speed and behaviour of each.
    pub settings: PedestrianSettings,
}

impl PedestrianSpawner {
    /// Creates a spawner of yielding pedestrians with usual size and speed.
    #[must_use]
    pub fn new(count: usize, seed: u64) -> Self {
        PedestrianSettings::default().spawner(count, seed)
    }
}

impl PedestrianSettings {
    /// Returns a spawner of this many pedestrians.
    #[must_use]
    pub const fn spawner(self, count: usize, seed: u64) -> PedestrianSpawner {
        PedestrianSpawner { count, seed, settings: self }
    }
}

impl PedestrianSpawner {
    /// Spawns pedestrians along the route that a robot plans from the start of a mission to its goal. They may walk in its zones.
    ///
    /// # Errors
    /// [`MissionError::Fault`] where there is no route; the others as [`PedestrianSpawner::spawn`].
    pub fn spawn_on_route(
        &self,
        mission: &Mission,
        config: &Config,
    ) -> Result<MovingObstacles, SimError> {
        if self.count == 0 {
            return Ok(MovingObstacles::default());
        }
        let path = first_path(mission, config)?;
        let robot_m = config.robot.footprint.circumscribed_radius_m();
        let ends = [mission.start.position(), mission.goal.position];
        self.spawn(&mission.map.obstacles(config.unknown), path.points(), &ends, robot_m)
    }

    /// Spawns pedestrians along a path. Each crosses or follows the roadway, on a walk of 4 to 12 m over free ground.
    ///
    /// No walk comes within 5 m of the points to keep clear, such as the robot's start and goal. On a path shorter than 20 m
    /// the limit is a quarter of its length, but a pedestrian keeps a gap of 0.3 m to a robot with this radius, metres, at such a point.
    ///
    /// # Errors
    /// [`SimError::Setting`] for a setting out of range; [`SimError::NoRoom`] where there is
    /// no walk for some of them.
    pub fn spawn(
        &self,
        obstacles: &ObstacleGrid,
        path: &[Point],
        keep_clear: &[Point],
        robot_radius_m: f64,
    ) -> Result<MovingObstacles, SimError> {
        let PedestrianSettings { radius_m, yields, leg_diameter_m, .. } = self.settings;
        self.validate()?;
        if self.count == 0 {
            return Ok(MovingObstacles::default());
        }
        let least_m = robot_radius_m + radius_m + LEAST_GAP_M;
        let places = Places::new(obstacles, radius_m, path, (keep_clear, least_m));
        let mut rng = Pcg64Mcg::seed_from_u64(self.seed);
        let mut moving_obstacles = Vec::with_capacity(self.count);
        for index in 0..self.count {
            let Some(route) = places.walk(index, self.count, &mut rng) else {
                return Err(SimError::NoRoom {
                    placed: moving_obstacles.len(),
                    asked: self.count,
                    least_m: *WALK_M.start(),
                    most_m: *WALK_M.end(),
                });
            };
            let mut walk = Patrol::new(route, self.draw_speed_m_s(&mut rng));
            walk.along_m = walk.route.length_m() * rng.random::<f64>();
            walk.forward = rng.random_bool(0.5);
            let phase_m = walk.along_m;
            let one = MovingObstacle::mid_patrol(radius_m, yields, walk)?;
            moving_obstacles.push(one.with_legs(leg_diameter_m, phase_m)?);
        }
        Ok(MovingObstacles::new(moving_obstacles))
    }

    /// Checks the settings, and that a list of all pedestrians has room in memory.
    pub(super) fn validate(&self) -> Result<(), SimError> {
        self.settings.validate()?;
        require(self.count <= MAX_COUNT, "count", self.count as f64, "at most 100000")?;
        Ok(())
    }

    /// Draws the walking speed of a pedestrian, m/s.
    pub(super) fn draw_speed_m_s(&self, rng: &mut Pcg64Mcg) -> f64 {
        let PedestrianSettings { min_speed, max_speed, .. } = self.settings;
        min_speed + (max_speed - min_speed) * rng.random::<f64>()
    }
}

/// The path that the robot of a mission plans first, on the way to its goal.
///
/// # Errors
/// No path leads to the goal.
pub fn first_path(mission: &Mission, config: &Config) -> Result<Path, SimError> {
    let closed = mission.navigation_map(config.unknown).closed();
    let (start, goal) = (mission.start.position(), mission.goal.position);
    let mut planner = config.route_planner(closed.frame().resolution_m);
    let plan = planner.plan(&closed, start, goal, &mut || 0.0);
    Ok(plan.map_err(|error| MissionError::from(Fault::Plan(error)))?.smoothed)
}

/// Free space and candidate points for walks.
struct Places<'a> {
    free: FreeSpace,
    /// Candidate points along the path, each with the path's direction.
    spots: Vec<(Point, f64)>,
    keep_clear: &'a [Point],
    keep_clear_m: f64,
}

impl<'a> Places<'a> {
    fn new(
        obstacles: &ObstacleGrid,
        radius_m: f64,
        path: &[Point],
        (keep_clear, least_m): (&'a [Point], f64),
    ) -> Self {
        let length: f64 = path.windows(2).map(|leg| (leg[1] - leg[0]).norm()).sum();
        let mut places = Self {
            free: FreeSpace::new(obstacles, radius_m),
            spots: Vec::new(),
            keep_clear,
            keep_clear_m: KEEP_CLEAR_M.min(length / 4.0).max(least_m),
        };
        for leg in path.windows(2) {
            let direction = bearing(&leg[0], &leg[1]);
            for point in Path::new(leg.to_vec()).samples(0.1) {
                let cell = places.free.frame().cell_of(&point);
                if places.may_walk(&point) && cell.is_some_and(|cell| places.free.is_free(cell)) {
                    places.spots.push((point, direction));
                }
            }
        }
        places
    }

    fn may_walk(&self, point: &Point) -> bool {
        self.keep_clear.iter().all(|place| (point - place).norm() >= self.keep_clear_m)
    }

    /// Finds a walk across or along the pedestrian's own part of the path, or elsewhere if there is none.
    fn walk(&self, index: usize, count: usize, rng: &mut Pcg64Mcg) -> Option<Path> {
        let spots = self.spots.len();
        let own = index * spots / count..(index + 1) * spots / count;
        for attempt in 0..ATTEMPTS {
            let range = if attempt < ATTEMPTS / 2 { own.clone() } else { 0..spots };
            if range.is_empty() {
                continue;
            }
            let (spot, direction) = self.spots[rng.random_range(range)];
            let crossing = rng.random_bool(0.5);
            let points = if crossing {
                self.crossing(&spot, direction)
            } else {
                winding_route(&self.free, &spot, &WALK_M, rng)
            };
            let route = points
                .map(Path::new)
                .filter(|route| WALK_M.contains(&route.length_m()))
                .filter(|route| route.samples(0.1).all(|point| self.may_walk(&point)));
            if route.is_some() {
                return route;
            }
        }
        None
    }

    /// A straight walk through a point, from wall to wall, as perpendicular to the path as possible.
    fn crossing(&self, spot: &Point, direction: f64) -> Option<Vec<Point>> {
        SLANTS_RAD
            .iter()
            .map(|slant| (direction + FRAC_PI_2 + slant) % TAU)
            .map(|across| straight_route(&self.free, spot, across, *WALK_M.end() / 2.0))
            .find(|[from, to]| (to - from).norm() >= *WALK_M.start())
            .map(Vec::from)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use crate::map::GridFrame;
    use crate::sim::Surprise;

    /// A path of 1 m: a quarter of it is less than the robot.
    #[test]
    fn no_walk_leads_through_the_robot() {
        let frame = GridFrame::new(100, 100, 0.1, Pose::default()).expect("a frame");
        let ground = ObstacleGrid::filled(frame, false);
        let (path, robot_m) = ([Point::new(4.0, 5.0), Point::new(5.0, 5.0)], 0.43);
        for seed in 0..20 {
            let Ok(people) = PedestrianSpawner::new(2, seed).spawn(&ground, &path, &path, robot_m)
            else {
                continue;
            };
            for disc in people.discs() {
                let gap_m = (disc.center() - path[0]).norm() - disc.radius - robot_m;
                assert!(gap_m > 0.2, "seed {seed}: {gap_m} m");
            }
        }
    }

    #[test]
    fn absurd_number_of_pedestrians_is_an_error() {
        let frame = GridFrame::new(10, 10, 1.0, Pose::default()).expect("a frame");
        let obstacles = ObstacleGrid::new(frame, vec![false; frame.len()]);
        let path = [Point::new(1.0, 5.0), Point::new(9.0, 5.0)];
        let spawner = PedestrianSpawner::new(usize::MAX, 1);
        let sudden = spawner.spawn_sudden(&obstacles, &Path::new(path.to_vec()), Surprise::Start);
        for spawned in [spawner.spawn(&obstacles, &path, &[], 0.0), sudden] {
            let error = spawned.expect_err("too many").to_string();
            assert!(error.starts_with("count is ") && error.contains("at most 100000"), "{error}");
        }
    }
}
