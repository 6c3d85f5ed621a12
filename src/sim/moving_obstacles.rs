//! The moving obstacles of a simulation.

use super::MovingObstacle;
use crate::geometry::Pose;
use crate::map::MovingDisc;
use crate::robot::Footprint;

/// Gap that a yielding obstacle leaves to the robot, metres. It takes no step that ends both nearer than this and nearer
/// than before.
pub const YIELD_GAP_M: f64 = 0.3;

/// Time, seconds, after which a yielding obstacle changes its route.
pub const YIELD_TIMEOUT_S: f64 = 3.0;

/// Longest step, seconds: 2 cm at 1 m/s.
const SUB_STEP_S: f64 = 0.02;

/// The moving obstacles, identified by their indices. They ignore each other.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MovingObstacles {
    moving: Vec<MovingObstacle>,
}

impl MovingObstacles {
    /// Creates the collection.
    #[must_use]
    pub const fn new(moving: Vec<MovingObstacle>) -> Self {
        Self { moving }
    }

    /// Number of obstacles, including those that have not yet appeared.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.moving.len()
    }

    /// Whether there are no obstacles.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.moving.is_empty()
    }

    /// Advances by a time, seconds, with the robot at a pose. Does nothing for a time that is not above zero.
    pub fn step(&mut self, time_s: f64, robot: &Pose, footprint: &Footprint) {
        if !(time_s > 0.0 && time_s.is_finite()) {
            return;
        }
        let steps = (time_s / SUB_STEP_S).ceil().max(1.0);
        for moving in &mut self.moving {
            for _ in 0..steps as u64 {
                moving.step(time_s / steps, robot, footprint);
            }
        }
    }

    /// Radius of each obstacle, metres.
    #[must_use]
    pub fn radii(&self) -> Vec<f64> {
        self.moving.iter().map(MovingObstacle::radius_m).collect()
    }

    /// Position and velocity of each obstacle; none for one that has not yet appeared.
    #[must_use]
    pub fn states(&self) -> Vec<Option<MovingDisc>> {
        self.moving.iter().map(MovingObstacle::disc).collect()
    }

    /// Positions and velocities of the obstacles that have appeared, in order.
    #[must_use]
    pub fn discs(&self) -> Vec<MovingDisc> {
        self.moving.iter().filter_map(MovingObstacle::disc).collect()
    }
}
