//! Motion to one random waypoint after another.

use std::sync::Arc;

use rand_pcg::Pcg64Mcg;

use super::SimError;
use super::rng::{RngStream, generator};
use super::route_sampler::roaming_route;
use crate::geometry::{Point, Vector};
use crate::global::Path;
use crate::map::{FreeSpace, ObstacleGrid};

/// Motion over free space around a home position to random waypoints.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct RandomWaypoint {
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
    pub(super) fn new(
        ground: &ObstacleGrid,
        radius_m: f64,
        speed_m_s: f64,
        home: Point,
        reach_m: f64,
        seed: u64,
    ) -> Result<Self, SimError> {
        let mut wander = Self {
            ground: Arc::new(FreeSpace::new(ground, radius_m)),
            home,
            reach_m,
            speed_m_s,
            rng: generator(seed, RngStream::Obstacles),
            route: Path::new(vec![home]),
            along_m: 0.0,
        };
        wander.choose();
        if wander.route.length_m() > 0.0 {
            Ok(wander)
        } else {
            Err(SimError::NoFreeSpace { x: home.x, y: home.y, radius_m, reach_m })
        }
    }

    pub(super) fn center(&self) -> Point {
        self.route.point_at(self.along_m)
    }

    pub(super) fn velocity(&self) -> Vector {
        self.route.direction_at(self.along_m) * self.speed_m_s
    }

    pub(super) fn center_after(&self, time_s: f64) -> Point {
        self.route.point_at(self.along_m + self.speed_m_s * time_s)
    }

    /// Chooses the next waypoint at the end of the route.
    pub(super) fn step(&mut self, time_s: f64) {
        self.along_m += self.speed_m_s * time_s;
        if self.along_m >= self.route.length_m() {
            self.choose();
        }
    }

    /// Chooses another waypoint; the route stays the same if there is none, as at a corner of a cell that is not free.
    pub(super) fn choose(&mut self) {
        let position = self.center();
        if let Some(walk) =
            roaming_route(&self.ground, &position, &self.home, self.reach_m, &mut self.rng)
        {
            self.route = Path::new(walk);
            self.along_m = 0.0;
        }
    }
}
