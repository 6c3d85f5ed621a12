//! One simulated moving obstacle: it patrols, follows a timed path, or moves between random waypoints.

use std::sync::Arc;

use rand_pcg::Pcg64Mcg;

use super::error::{above_zero, at_least_zero};
use super::gait::Gait;
use super::route_sampler::{is_in_sight, roaming_route};
use super::{RngStream, SimError, TimedPath, YIELD_GAP_M, YIELD_TIMEOUT_S, generator};
use crate::geometry::{Point, Pose, Vector};
use crate::global::Path;
use crate::map::{FreeSpace, MovingDisc, ObstacleGrid};
use crate::robot::Footprint;
use crate::settings::require;

/// When an obstacle appears. Until then it is invisible and touches nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum SpawnTrigger {
    /// At a time, seconds after the start.
    AtTime(f64),
    /// When the robot's origin is within a distance, metres, of the obstacle's start.
    WithinDistance(f64),
}

/// A disc that moves by itself and may yield to the robot.
///
/// A yielding obstacle stops while its next step would end within [`YIELD_GAP_M`] of the robot and nearer than before;
/// after 3 s it changes its route. It does not appear within that gap either. It never hits the robot,
/// but the robot may hit it. Other obstacles ignore the robot.
#[derive(Clone, Debug, PartialEq)]
pub struct MovingObstacle {
    radius_m: f64,
    yields: bool,
    /// None after it has appeared.
    appears: Option<SpawnTrigger>,
    /// What a lidar sees through: the obstacle appears only where the robot cannot see its start. None: anywhere.
    seen_over: Option<Arc<FreeSpace>>,
    /// Time since the start while it has not appeared, seconds.
    waited_s: f64,
    /// Time for which it has yielded, seconds; zero while it moves.
    held_s: f64,
    /// The legs that a lidar sees instead of the disc.
    gait: Option<Gait>,
    /// None once it walks.
    starts: Option<StartTrigger>,
    motion: Motion,
}

/// An obstacle stands until the robot's origin is within a distance, metres, of a place.
#[derive(Clone, Copy, Debug, PartialEq)]
struct StartTrigger {
    place: Point,
    distance_m: f64,
}

#[derive(Clone, Debug, PartialEq)]
enum Motion {
    Patrol(Patrol),
    /// A path, and the time since its start, below its period.
    TimedPath(TimedPath, f64),
    RandomWaypoint(Box<RandomWaypoint>),
}

impl MovingObstacle {
    /// Creates a yielding obstacle that moves along a route and back at a speed, m/s, which may be zero. It reverses
    /// after the yield timeout. The route is not checked for obstacles.
    ///
    /// # Errors
    /// [`SimError::Setting`] for a radius that is not above zero, a speed below zero, an empty route, or any of
    /// these not finite.
    pub fn patrol(radius_m: f64, speed_m_s: f64, route: Vec<Point>) -> Result<Self, SimError> {
        at_least_zero("speed", speed_m_s)?;
        let points = route.len() as f64;
        require(points > 0.0, "number of points", points, "at least one")?;
        for value in route.iter().flat_map(|point| [point.x, point.y]) {
            require(value.is_finite(), "point of a route", value, "finite")?;
        }
        Self::new(radius_m, true, Motion::Patrol(Patrol::new(Path::new(route), speed_m_s)))
    }

    /// Creates an obstacle that follows a timed path and does not yield. If it is made to yield, its clock stops while
    /// it yields.
    ///
    /// # Errors
    /// [`SimError::Setting`] for a radius that is not finite and above zero.
    pub fn timed_path(radius_m: f64, path: TimedPath) -> Result<Self, SimError> {
        Self::new(radius_m, false, Motion::TimedPath(path, 0.0))
    }

    /// Creates a yielding obstacle that moves at a speed, m/s, to one random waypoint after another, over free space
    /// within a distance, metres, of its start. It chooses another waypoint after the yield timeout. The same seed
    /// gives the same waypoints.
    ///
    /// # Errors
    /// [`SimError::Setting`] for a radius, speed or distance that is not finite and above zero;
    /// [`SimError::NoFreeSpace`] where there is no free space at or around the start.
    pub fn random_waypoint(
        radius_m: f64,
        speed_m_s: f64,
        start: Point,
        wander_m: f64,
        ground: &ObstacleGrid,
        seed: u64,
    ) -> Result<Self, SimError> {
        above_zero("radius", radius_m)?;
        above_zero("speed", speed_m_s)?;
        above_zero("wander_m", wander_m)?;
        let motion = RandomWaypoint::new(ground, radius_m, speed_m_s, start, wander_m, seed)?;
        Self::new(radius_m, true, Motion::RandomWaypoint(Box::new(motion)))
    }

    fn new(radius_m: f64, yields: bool, motion: Motion) -> Result<Self, SimError> {
        above_zero("radius", radius_m)?;
        Ok(Self {
            radius_m,
            yields,
            appears: None,
            seen_over: None,
            waited_s: 0.0,
            held_s: 0.0,
            gait: None,
            starts: None,
            motion,
        })
    }

    /// Creates an obstacle in the middle of a patrol.
    pub(super) fn mid_patrol(radius_m: f64, yields: bool, walk: Patrol) -> Result<Self, SimError> {
        Self::new(radius_m, yields, Motion::Patrol(walk))
    }

    /// Sets whether the obstacle yields to the robot.
    #[must_use]
    pub fn yielding(self, yields: bool) -> Self {
        Self { yields, ..self }
    }

    /// Sets when the obstacle appears at its start; it begins to move then.
    ///
    /// # Errors
    /// [`SimError::Setting`] for a time or distance that is not finite and at least zero.
    pub fn spawned_by(self, appears: SpawnTrigger) -> Result<Self, SimError> {
        match appears {
            SpawnTrigger::AtTime(time_s) => at_least_zero("appears_at_s", time_s)?,
            SpawnTrigger::WithinDistance(distance_m) => {
                at_least_zero("appears_within_m", distance_m)?;
            }
        }
        Ok(Self { appears: Some(appears), ..self })
    }

    /// Lets the obstacle appear only while the robot's origin cannot see its start over this space. A real
    /// obstacle cannot appear in the view of a robot.
    #[cfg(feature = "experiment")]
    #[must_use]
    pub(crate) fn out_of_sight_over(self, transparent: Arc<FreeSpace>) -> Self {
        Self { seen_over: Some(transparent), ..self }
    }

    /// Gives the obstacle two legs of a diameter, metres, which a lidar sees instead of its disc. They walk within the disc and
    /// stand with it; `phase_m` is the distance that they have walked. A diameter of zero keeps the disc.
    ///
    /// # Errors
    /// [`SimError::Setting`] for a diameter below zero or above the obstacle's, or a number that is not finite.
    pub fn with_legs(self, leg_diameter_m: f64, phase_m: f64) -> Result<Self, SimError> {
        at_least_zero("phase", phase_m)?;
        let fits = (0.0..=2.0 * self.radius_m).contains(&leg_diameter_m);
        require(fits, "leg_diameter", leg_diameter_m, "zero to the diameter of the obstacle")?;
        Ok(Self {
            gait: (leg_diameter_m > 0.0).then(|| Gait::new(leg_diameter_m, phase_m)),
            ..self
        })
    }

    /// Lets the obstacle stand until the robot's origin is within a distance, metres, of a place.
    ///
    /// # Errors
    /// [`SimError::Setting`] for a distance that is not finite and at least zero.
    pub fn starting_within(self, distance_m: f64, place: Point) -> Result<Self, SimError> {
        at_least_zero("starts_within_m", distance_m)?;
        Ok(Self { starts: Some(StartTrigger { place, distance_m }), ..self })
    }

    /// Whether a lidar sees legs instead of the disc.
    pub(super) const fn has_legs(&self) -> bool {
        self.gait.is_some()
    }

    /// The legs, after the obstacle has appeared; none without legs.
    #[must_use]
    pub fn legs(&self) -> Option<[MovingDisc; 2]> {
        let body = self.disc()?;
        let velocity = Vector::new(body.vx, body.vy);
        Some(self.gait.as_ref()?.legs(&body.center(), self.radius_m, &velocity))
    }

    /// Radius, metres.
    #[must_use]
    pub const fn radius_m(&self) -> f64 {
        self.radius_m
    }

    /// Position and velocity, after it has appeared; the velocity is zero while it yields.
    #[must_use]
    pub fn disc(&self) -> Option<MovingDisc> {
        if self.appears.is_some() {
            return None;
        }
        let (center, velocity) = self.motion.after(0.0);
        let stands = self.held_s > 0.0 || self.starts.is_some();
        let velocity = if stands { Vector::ZERO } else { velocity };
        Some(MovingDisc {
            x: center.x,
            y: center.y,
            radius: self.radius_m,
            vx: velocity.x,
            vy: velocity.y,
        })
    }

    /// Advances by a time, seconds, with the robot at a pose.
    pub(super) fn step(&mut self, time_s: f64, robot: &Pose, footprint: &Footprint) {
        let walked = self.walk(time_s, robot, footprint);
        if let Some(gait) = &mut self.gait {
            gait.step(&walked.unwrap_or(Vector::ZERO), time_s);
        }
    }

    /// Advances the motion; returns the velocity of an obstacle that moves.
    fn walk(&mut self, time_s: f64, robot: &Pose, footprint: &Footprint) -> Option<Vector> {
        let gap = |center| footprint.gap_to_disc_m(robot, &center, self.radius_m);
        if let Some(appears) = self.appears {
            self.waited_s += time_s;
            let start = self.motion.after(0.0).0;
            let is_time = match appears {
                // The sum of many steps is rounded.
                SpawnTrigger::AtTime(at_s) => self.waited_s >= at_s - 1e-9,
                SpawnTrigger::WithinDistance(distance_m) => {
                    (start - robot.position()).norm() <= distance_m
                }
            };
            let is_seen = |over: &Arc<FreeSpace>| is_in_sight(over, &robot.position(), &start);
            let is_hidden = || !self.seen_over.as_ref().is_some_and(is_seen);
            if is_time && is_hidden() && !(self.yields && gap(start) < YIELD_GAP_M) {
                self.appears = None;
            }
            return None;
        }
        if let Some(StartTrigger { place, distance_m }) = self.starts {
            if (place - robot.position()).norm() > distance_m {
                return None;
            }
            self.starts = None;
        }
        if self.yields {
            let ahead = gap(self.motion.after(time_s).0);
            if ahead < YIELD_GAP_M && ahead < gap(self.motion.after(0.0).0) {
                self.yield_to_robot(time_s);
                return None;
            }
        }
        self.held_s = 0.0;
        let velocity = self.motion.after(0.0).1;
        match &mut self.motion {
            Motion::Patrol(walk) => walk.step(time_s),
            Motion::TimedPath(path, now_s) => *now_s = path.within_period(*now_s + time_s),
            Motion::RandomWaypoint(motion) => motion.step(time_s),
        }
        Some(velocity)
    }

    fn yield_to_robot(&mut self, time_s: f64) {
        self.held_s += time_s;
        if self.held_s >= YIELD_TIMEOUT_S {
            match &mut self.motion {
                Motion::Patrol(walk) => walk.reverse(),
                Motion::TimedPath(..) => return,
                Motion::RandomWaypoint(motion) => motion.choose(),
            }
            self.held_s = 0.0;
        }
    }
}

impl Motion {
    /// Centre and velocity after a time, seconds.
    fn after(&self, time_s: f64) -> (Point, Vector) {
        match self {
            Self::Patrol(walk) => walk.after(time_s),
            Self::TimedPath(path, now_s) => path.at(now_s + time_s),
            Self::RandomWaypoint(motion) => motion.after(time_s),
        }
    }
}

/// Motion between the ends of a route at constant speed.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Patrol {
    pub(super) route: Path,
    speed_m_s: f64,
    /// Distance along the route.
    pub(super) along_m: f64,
    pub(super) forward: bool,
}

impl Patrol {
    pub(super) const fn new(route: Path, speed_m_s: f64) -> Self {
        Self { route, speed_m_s, along_m: 0.0, forward: true }
    }

    fn after(&self, time_s: f64) -> (Point, Vector) {
        let (along_m, forward) = self.state_after(time_s);
        let speed_m_s = if forward { self.speed_m_s } else { -self.speed_m_s };
        (self.route.point_at(along_m), self.route.direction_at(along_m) * speed_m_s)
    }

    fn step(&mut self, time_s: f64) {
        (self.along_m, self.forward) = self.state_after(time_s);
    }

    const fn reverse(&mut self) {
        self.forward = !self.forward;
    }

    /// Distance along the route and direction after a step; it reverses at the ends.
    fn state_after(&self, time_s: f64) -> (f64, bool) {
        let length = self.route.length_m();
        let stride = self.speed_m_s * time_s;
        let (along, forward) = if self.forward {
            (self.along_m + stride, true)
        } else {
            (self.along_m - stride, false)
        };
        if along > length {
            ((2.0 * length - along).max(0.0), false)
        } else if along < 0.0 {
            ((-along).min(length), true)
        } else {
            (along, forward)
        }
    }
}

/// Motion over free space around a home position to random waypoints.
#[derive(Clone, Debug, PartialEq)]
struct RandomWaypoint {
    ground: Arc<FreeSpace>,
    home: Point,
    reach_m: f64,
    speed_m_s: f64,
    rng: Pcg64Mcg,
    route: Path,
    /// Distance along the route.
    along_m: f64,
}

impl RandomWaypoint {
    fn new(
        ground: &ObstacleGrid,
        radius_m: f64,
        speed_m_s: f64,
        home: Point,
        reach_m: f64,
        seed: u64,
    ) -> Result<Self, SimError> {
        let mut motion = Self {
            ground: Arc::new(FreeSpace::new(ground, radius_m)),
            home,
            reach_m,
            speed_m_s,
            rng: generator(seed, RngStream::Obstacles),
            route: Path::new(vec![home]),
            along_m: 0.0,
        };
        motion.choose();
        if motion.route.length_m() > 0.0 {
            Ok(motion)
        } else {
            Err(SimError::NoFreeSpace { x: home.x, y: home.y, radius_m, reach_m })
        }
    }

    fn after(&self, time_s: f64) -> (Point, Vector) {
        let along_m = self.along_m + self.speed_m_s * time_s;
        (self.route.point_at(along_m), self.route.direction_at(along_m) * self.speed_m_s)
    }

    /// Chooses the next waypoint at the end of the route.
    fn step(&mut self, time_s: f64) {
        self.along_m += self.speed_m_s * time_s;
        if self.along_m >= self.route.length_m() {
            self.choose();
        }
    }

    /// Chooses another waypoint; the route stays the same if there is none, as at a corner of a cell that is not free.
    fn choose(&mut self) {
        let position = self.route.point_at(self.along_m);
        if let Some(walk) =
            roaming_route(&self.ground, &position, &self.home, self.reach_m, &mut self.rng)
        {
            self.route = Path::new(walk);
            self.along_m = 0.0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{Cell, GridFrame};

    /// A wall with a door, and an obstacle that waits behind the wall.
    #[test]
    fn obstacle_out_of_sight_appears_behind_a_wall_only() {
        let frame = GridFrame::new(60, 60, 0.1, Pose::default()).expect("a valid size");
        let mut ground = ObstacleGrid::filled(frame, false);
        (0..60).filter(|row| !(25..35).contains(row)).for_each(|row| {
            ground.set(Cell::new(30, row), true);
        });
        let transparent = Arc::new(FreeSpace::new(&ground, 0.0));
        let waits = MovingObstacle::patrol(0.3, 0.0, vec![Point::new(4.0, 1.0)]).expect("valid");
        let waits = waits.spawned_by(SpawnTrigger::WithinDistance(4.0)).expect("valid");
        let mut waits = waits.out_of_sight_over(transparent);
        let footprint = Footprint::round(0.3).expect("a valid radius");
        let mut appears_for = |x: f64, y: f64| {
            waits.step(0.1, &Pose::new(x, y, 0.0), &footprint);
            waits.disc().is_some()
        };
        assert!(!appears_for(2.0, 5.0), "through the door, in sight");
        assert!(!appears_for(0.1, 4.0), "too far away");
        assert!(appears_for(2.0, 1.0), "behind the wall");
    }
}
