//! One moving obstacle: how it moves, whether it minds the robot, and since when it is there.

use super::error::{above_zero, at_least_zero};
use super::patrol::Patrol;
use super::random_waypoint::RandomWaypoint;
use super::timed_path::{TimedPath, TimedPathPlayer};
use super::{SimError, YIELD_GAP_M, YIELD_TIMEOUT_S};
use crate::geometry::{Point, Pose, Vector};
use crate::global::Path;
use crate::map::{MovingDisc, ObstacleGrid};
use crate::robot::Footprint;
use crate::settings::require;

/// When an obstacle appears that is not there from the start. Until then it touches nothing and nothing sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SpawnTrigger {
    /// At a time, seconds after the start.
    AtTime(f64),
    /// When the robot's origin comes within a distance, metres, of the place where it appears.
    WithinDistance(f64),
}

/// A disc that moves by itself.
///
/// One that yields holds while its next step would bring it within [`YIELD_GAP_M`] of the robot and nearer than it is,
/// and gives up its way after [`YIELD_TIMEOUT_S`]; nor does it appear within that gap. So it never walks into the robot,
/// though the robot may drive into it. One that does not yield takes no notice of the robot.
#[derive(Clone, Debug, PartialEq)]
pub struct MovingObstacle {
    radius_m: f64,
    yields: bool,
    /// None once it is there.
    appears: Option<SpawnTrigger>,
    /// How long it has been waited for.
    waited_s: f64,
    /// How long it has stood for the robot; zero while it moves.
    held_s: f64,
    motion: Motion,
}

#[derive(Clone, Debug, PartialEq)]
enum Motion {
    Patrol(Patrol),
    TimedPathPlayer(TimedPathPlayer),
    RandomWaypoint(Box<RandomWaypoint>),
}

impl MovingObstacle {
    /// Somebody who walks a route from end to end and back, at a speed in m/s, which may be zero; yields. Patience gone,
    /// it turns round. Whether the route is free is the caller's affair.
    ///
    /// # Errors
    /// [`SimError::Setting`] for a radius that is not above zero, a speed below zero, a route of no point, or any of
    /// these not finite.
    pub fn patrol(radius_m: f64, speed_m_s: f64, route: Vec<Point>) -> Result<Self, SimError> {
        at_least_zero("speed", speed_m_s)?;
        let points = route.len() as f64;
        require(points > 0.0, "number of points", points, "at least one")?;
        for value in route.iter().flat_map(|point| [point.x, point.y]) {
            require(value.is_finite(), "point of a route", value, "finite")?;
        }
        Self::new(
            radius_m,
            true,
            Motion::Patrol(Patrol::new(Path::new(route), speed_m_s)),
        )
    }

    /// A body that plays a script, and does not yield. One that is made to yield stops its clock while it holds, however
    /// long.
    ///
    /// # Errors
    /// [`SimError::Setting`] for a radius that is not finite and above zero.
    pub fn timed_path(radius_m: f64, script: TimedPath) -> Result<Self, SimError> {
        Self::new(
            radius_m,
            false,
            Motion::TimedPathPlayer(TimedPathPlayer::new(script)),
        )
    }

    /// Somebody who starts at a place and walks, at a speed in m/s, to one random place after another, round corners, over
    /// ground that is free for it and within a distance, metres, of its start; yields. Patience gone, it makes for
    /// another place. Same seed, same places.
    ///
    /// # Errors
    /// [`SimError::Setting`] for a radius, speed or distance that is not finite and above zero;
    /// [`SimError::NowhereToGo`] where the start is not free ground or has none about it.
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
        let wander = RandomWaypoint::new(ground, radius_m, speed_m_s, start, wander_m, seed)?;
        Self::new(radius_m, true, Motion::RandomWaypoint(Box::new(wander)))
    }

    fn new(radius_m: f64, yields: bool, motion: Motion) -> Result<Self, SimError> {
        above_zero("radius", radius_m)?;
        Ok(Self {
            radius_m,
            yields,
            appears: None,
            waited_s: 0.0,
            held_s: 0.0,
            motion,
        })
    }

    /// A walk that is already under way.
    pub(super) fn under_way(radius_m: f64, yields: bool, walk: Patrol) -> Result<Self, SimError> {
        Self::new(radius_m, yields, Motion::Patrol(walk))
    }

    /// The same, minding the robot or not.
    #[must_use]
    pub fn yielding(self, yields: bool) -> Self {
        Self { yields, ..self }
    }

    /// The same, but not there from the start: it appears where it would have started, and only then begins to move.
    ///
    /// # Errors
    /// [`SimError::Setting`] for a time or distance that is not finite and at least zero.
    pub fn spawned_by(self, appears: SpawnTrigger) -> Result<Self, SimError> {
        match appears {
            SpawnTrigger::AtTime(time_s) => at_least_zero("appears_at_s", time_s)?,
            SpawnTrigger::WithinDistance(distance_m) => {
                at_least_zero("appears_within_m", distance_m)?
            }
        }
        Ok(Self {
            appears: Some(appears),
            ..self
        })
    }

    /// Its radius, metres, whether it is there or not.
    #[must_use]
    pub const fn radius_m(&self) -> f64 {
        self.radius_m
    }

    /// Where it is now and how it moves, if it is there; one that holds does not move.
    #[must_use]
    pub fn disc(&self) -> Option<MovingDisc> {
        if self.appears.is_some() {
            return None;
        }
        let center = self.center();
        let velocity = if self.held_s > 0.0 {
            Vector::zeros()
        } else {
            self.velocity()
        };
        Some(MovingDisc {
            x: center.x,
            y: center.y,
            radius: self.radius_m,
            vx: velocity.x,
            vy: velocity.y,
        })
    }

    /// Lets time pass, seconds, while the robot stands at a pose.
    pub(super) fn step(&mut self, time_s: f64, robot: &Pose, footprint: &Footprint) {
        let gap = |center| footprint.gap_to_disc_m(robot, &center, self.radius_m);
        if let Some(appears) = self.appears {
            self.waited_s += time_s;
            let start = self.center();
            let is_time = match appears {
                // The sum of many steps may fall short of their number by its rounding.
                SpawnTrigger::AtTime(at_s) => self.waited_s >= at_s - 1e-9,
                SpawnTrigger::WithinDistance(distance_m) => {
                    (start - robot.position()).norm() <= distance_m
                }
            };
            if is_time && !(self.yields && gap(start) < YIELD_GAP_M) {
                self.appears = None;
            }
            return;
        }
        if self.yields {
            let ahead = gap(self.center_after(time_s));
            if ahead < YIELD_GAP_M && ahead < gap(self.center()) {
                self.hold(time_s);
                return;
            }
        }
        self.held_s = 0.0;
        match &mut self.motion {
            Motion::Patrol(walk) => walk.step(time_s),
            Motion::TimedPathPlayer(script) => script.step(time_s),
            Motion::RandomWaypoint(wander) => wander.step(time_s),
        }
    }

    fn hold(&mut self, time_s: f64) {
        self.held_s += time_s;
        if self.held_s >= YIELD_TIMEOUT_S {
            match &mut self.motion {
                Motion::Patrol(walk) => walk.turn_round(),
                Motion::TimedPathPlayer(_) => return,
                Motion::RandomWaypoint(wander) => wander.choose(),
            }
            self.held_s = 0.0;
        }
    }

    fn center(&self) -> Point {
        match &self.motion {
            Motion::Patrol(walk) => walk.center(),
            Motion::TimedPathPlayer(script) => script.center(),
            Motion::RandomWaypoint(wander) => wander.center(),
        }
    }

    fn velocity(&self) -> Vector {
        match &self.motion {
            Motion::Patrol(walk) => walk.velocity(),
            Motion::TimedPathPlayer(script) => script.velocity(),
            Motion::RandomWaypoint(wander) => wander.velocity(),
        }
    }

    fn center_after(&self, time_s: f64) -> Point {
        match &self.motion {
            Motion::Patrol(walk) => walk.center_after(time_s),
            Motion::TimedPathPlayer(script) => script.center_after(time_s),
            Motion::RandomWaypoint(wander) => wander.center_after(time_s),
        }
    }
}
