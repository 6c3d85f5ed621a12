//! One run: a world, a robot with an empty map, and the rules.

use std::sync::Arc;

use super::{BarnRow, BarnWorld, Cylinder, empty_map, score, truth};
use crate::experiment::worlds::{RunFigures, RunKey, Verdict, WorldError, WorldTask};
use crate::geometry::{Point, Pose};
use crate::navigator::Goal;
use crate::runtime::{Config, Mission, MissionResult};
use crate::sim::Simulation;

/// From where to where, and when a run is over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Course {
    /// Where the robot starts, standing.
    pub start: Pose,
    /// Where it shall go.
    pub goal: Point,
    /// The goal is reached when the true pose is within this of it, metres.
    pub goal_radius_m: f64,
    /// The run ends after this long, seconds.
    pub time_limit_s: f64,
}

impl Course {
    /// BARN's: the same in every world. The challenge's script: `run.py` of `Daffan/the-barn-challenge`, with the start
    /// at the centre of the walls, where the paths begin.
    pub const BARN: Self = Self {
        start: Pose::new(-2.25, 3.0, 1.57),
        goal: Point::new(-2.25, 13.0),
        goal_radius_m: 1.0,
        time_limit_s: 100.0,
    };
}

/// What is to be driven.
#[derive(Clone, Debug, PartialEq)]
pub struct Task {
    /// The world's number.
    pub world: u32,
    /// What stands in it.
    pub cylinders: Vec<Cylinder>,
    /// From where to where.
    pub course: Course,
    /// Time that the benchmark's path takes at 2 m/s, seconds.
    pub optimal_time_s: f64,
    /// Seed of the noise.
    pub seed: u64,
}

impl Task {
    /// A run of a world by BARN's rules.
    #[must_use]
    pub fn barn(world: &BarnWorld, seed: u64) -> Self {
        Self {
            world: world.number,
            cylinders: world.cylinders.clone(),
            course: Course::BARN,
            optimal_time_s: world.optimal_time_s,
            seed,
        }
    }
}

impl WorldTask for Task {
    type Row = BarnRow;

    fn key(&self) -> RunKey {
        RunKey {
            world: self.world,
            seed: self.seed,
        }
    }

    /// An empty map, and the cylinders as the truth.
    fn simulation(&self) -> Result<Simulation, WorldError> {
        let (world, course) = (self.world, &self.course);
        let ground = |error| WorldError::Ground { world, error };
        let goal = Goal {
            position: course.goal,
            yaw: None,
        };
        let map = empty_map(&self.cylinders, course).map_err(ground)?;
        Ok(Simulation {
            truth: Some(truth(&self.cylinders, course).map_err(ground)?),
            seed: self.seed,
            ..Simulation::new(Mission {
                time_limit_s: course.time_limit_s,
                done_within_m: Some(course.goal_radius_m),
                ..Mission::new(Arc::new(map), course.start, goal)
            })
        })
    }

    fn row(&self, _: &Config, figures: RunFigures, _: Option<&MissionResult>) -> BarnRow {
        let reached = figures.verdict == Verdict::Succeeded;
        BarnRow {
            world: self.world,
            seed: self.seed,
            result: figures.verdict,
            time_s: figures.time_s,
            travelled_m: figures.travelled_m,
            min_clearance_m: figures.min_clearance_m,
            optimal_time_s: self.optimal_time_s,
            score: score(reached, figures.time_s, self.optimal_time_s),
            fault: figures.fault,
            decision_p50_ms: figures.decision_p50_ms,
            decision_p99_ms: figures.decision_p99_ms,
        }
    }
}
