//! The simulated world: static obstacles, moving discs, and the gap between them and the robot.

use crate::geometry::Pose;
use crate::map::{MovingDisc, ObstacleGrid};
use crate::robot::Footprint;
use crate::runtime::ObstacleGap;

/// Everything that the robot can touch. All gaps are in metres, exact to rounding; at or below zero there is contact.
#[derive(Clone, Debug)]
pub struct World {
    obstacles: ObstacleGap,
    /// Moving obstacles at their present positions.
    pub moving: Vec<MovingDisc>,
}

impl World {
    /// Creates a world without moving obstacles.
    #[must_use]
    pub fn new(obstacles: ObstacleGrid) -> Self {
        Self { obstacles: ObstacleGap::new(obstacles), moving: Vec::new() }
    }

    /// The static obstacles.
    #[must_use]
    pub const fn obstacles(&self) -> &ObstacleGrid {
        self.obstacles.obstacles()
    }

    /// The smallest gap between the footprint and anything solid.
    #[must_use]
    pub fn gap_m(&self, footprint: &Footprint, pose: &Pose) -> f64 {
        self.gap_to_static_m(footprint, pose).min(self.gap_to_moving_m(footprint, pose))
    }

    /// The smallest gap between the footprint and the static obstacles: see [`ObstacleGap::gap_m`].
    #[must_use]
    pub fn gap_to_static_m(&self, footprint: &Footprint, pose: &Pose) -> f64 {
        self.obstacles.gap_m(footprint, pose)
    }

    /// The smallest gap between the footprint and the moving obstacles; infinite without any.
    #[must_use]
    pub fn gap_to_moving_m(&self, footprint: &Footprint, pose: &Pose) -> f64 {
        self.moving
            .iter()
            .map(|disc| footprint.gap_to_disc_m(pose, &disc.center(), disc.radius))
            .fold(f64::INFINITY, f64::min)
    }
}
