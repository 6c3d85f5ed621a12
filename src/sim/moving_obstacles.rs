//! All that moves in a simulation but the robot.

use super::MovingObstacle;
use crate::geometry::Pose;
use crate::map::MovingDisc;
use crate::robot::Footprint;

/// The gap to the robot, metres, that a yielding obstacle keeps: it does not take a step that would end nearer and
/// bring it nearer still.
pub const YIELD_GAP_M: f64 = 0.3;

/// How long, seconds, a yielding obstacle stands before it goes another way.
pub const YIELD_TIMEOUT_S: f64 = 3.0;

/// Longest step of a walk, seconds: at 1 m/s a walker looks again every 2 cm.
const SUB_STEP_S: f64 = 0.02;

/// All moving obstacles of a simulation, each known by its place in the list from start to end. They do not mind each
/// other.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MovingObstacles {
    moving: Vec<MovingObstacle>,
}

impl MovingObstacles {
    /// These obstacles.
    #[must_use]
    pub const fn new(moving: Vec<MovingObstacle>) -> Self {
        Self { moving }
    }

    /// How many there are, those included that have not yet appeared.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.moving.len()
    }

    /// Whether there is none.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.moving.is_empty()
    }

    /// Lets everybody move for a time, seconds, while the robot stands at a pose; none for a time that is not above
    /// zero.
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

    /// Radius of each, metres.
    #[must_use]
    pub fn radii(&self) -> Vec<f64> {
        self.moving.iter().map(MovingObstacle::radius_m).collect()
    }

    /// Where each is now and how it moves; none for one that has not yet appeared.
    #[must_use]
    pub fn places(&self) -> Vec<Option<MovingDisc>> {
        self.moving.iter().map(MovingObstacle::disc).collect()
    }

    /// Those that are there, in order: as [`MovingObstacles::places`] without the gaps.
    #[must_use]
    pub fn discs(&self) -> Vec<MovingDisc> {
        self.moving
            .iter()
            .filter_map(MovingObstacle::disc)
            .collect()
    }
}
