//! The rules of a run: start, goal, end and score.

use std::sync::Arc;

use super::{BarnWorld, empty_map, truth};
use crate::geometry::{Point, Pose};
use crate::map::MapError;
use crate::navigator::Goal;
use crate::runtime::Mission;
use crate::sim::Simulation;

/// Start, goal and end conditions of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Course {
    /// Where the robot starts, standing.
    pub start: Pose,
    /// The goal.
    pub goal: Point,
    /// The goal is reached when the true pose is this close to it, metres.
    pub goal_radius_m: f64,
    /// The run ends after this time, seconds.
    pub time_limit_s: f64,
}

impl Course {
    /// BARN's course, the same in every world. Source: `run.py` of `Daffan/the-barn-challenge`, with the start at the centre of
    /// the walls, where the paths begin.
    pub const BARN: Self = Self {
        start: Pose::new(-2.25, 3.0, 1.57),
        goal: Point::new(-2.25, 13.0),
        goal_radius_m: 1.0,
        time_limit_s: 100.0,
    };
}

impl BarnWorld {
    /// The simulation of a seed: an empty map, and the cylinders as the truth.
    ///
    /// # Errors
    /// Fails when the world is too large for a grid.
    pub fn simulation(&self, seed: u64) -> Result<Simulation, MapError> {
        let course = &self.course;
        let goal = Goal { position: course.goal, yaw: None };
        let map = empty_map(&self.cylinders, course)?;
        Ok(Simulation {
            truth: Some(truth(&self.cylinders, course)?),
            seed,
            ..Simulation::new(Mission {
                time_limit_s: course.time_limit_s,
                done_within_m: Some(course.goal_radius_m),
                ..Mission::new(Arc::new(map), course.start, goal)
            })
        })
    }
}

/// The challenge's score of a run: zero unless it reached the goal, else `OT / clip(T, 2 OT, 8 OT)`, from 0.125 to 0.5.
/// `time_s` is T, `optimal_time_s` OT, above zero.
///
/// T counts from the first tick; the challenge's clock starts when the robot has moved 0.1 m.
#[must_use]
pub fn score(reached: bool, time_s: f64, optimal_time_s: f64) -> f64 {
    if !reached {
        return 0.0;
    }
    optimal_time_s / time_s.clamp(2.0 * optimal_time_s, 8.0 * optimal_time_s)
}
