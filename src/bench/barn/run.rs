//! One run: a world, a robot with an empty map, and the rules.

use std::sync::Arc;

use super::{BarnError, BarnRow, BarnWorld, Cylinder, Verdict, empty_map, score, truth};
use crate::bench::Latencies;
use crate::geometry::{Point, Pose};
use crate::local::CpuEngine;
use crate::navigator::Goal;
use crate::sim::{Config, Mission, MissionError, MissionResult, Observer, SimError, run_mission};

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

    /// The mission of this run: an empty map, and the cylinders as the truth.
    ///
    /// # Errors
    /// When the world is too large for a grid.
    pub fn mission(&self) -> Result<Mission, BarnError> {
        let (world, course) = (self.world, &self.course);
        let ground = |error| BarnError::Ground { world, error };
        let goal = Goal {
            position: course.goal,
            yaw: None,
        };
        let map = empty_map(&self.cylinders, course).map_err(ground)?;
        Ok(Mission {
            truth: Some(truth(&self.cylinders, course).map_err(ground)?),
            seed: self.seed,
            time_limit_s: course.time_limit_s,
            done_within_m: Some(course.goal_radius_m),
            ..Mission::new(Arc::new(map), course.start, goal)
        })
    }
}

/// Drives, on one thread; times each decision by `clock`, in seconds. Without a result where the navigator found no way
/// to begin with.
///
/// # Errors
/// When the world is too large, or the configuration is not sound.
pub fn drive(
    task: &Task,
    config: &Config,
    clock: &mut dyn FnMut() -> f64,
) -> Result<(BarnRow, Option<MissionResult>), BarnError> {
    let mission = task.mission()?;
    let engine = Box::new(CpuEngine::single_threaded());
    let mut observer = Observer {
        clock,
        progress: &mut |_| {},
    };
    match run_mission(&mission, config, engine, &mut observer) {
        Ok(result) => Ok((task.row(&result), Some(result))),
        Err(MissionError::Fault(fault)) => Ok((task.refused(&fault.to_string()), None)),
        Err(MissionError::Sim(error)) => Err(task.unsound(error)),
    }
}

impl Task {
    fn row(&self, result: &MissionResult) -> BarnRow {
        let mut times = Latencies::default();
        for &seconds in &result.decision_s {
            // A clock that ran backwards would give no time.
            let _ = times.record(seconds);
        }
        let times = times.summary();
        let verdict = Verdict::of(result);
        let reached = verdict == Verdict::Succeeded;
        BarnRow {
            world: self.world,
            seed: self.seed,
            result: verdict,
            time_s: result.time_s,
            travelled_m: result.travelled_m,
            min_clearance_m: Some(result.min_clearance_m).filter(|gap_m| gap_m.is_finite()),
            optimal_time_s: self.optimal_time_s,
            score: score(reached, result.time_s, self.optimal_time_s),
            fault: result.fault.as_ref().map(ToString::to_string),
            decision_p50_ms: times.map(|times| times.p50_ms),
            decision_p99_ms: times.map(|times| times.p99_ms),
        }
    }

    fn refused(&self, fault: &str) -> BarnRow {
        BarnRow {
            world: self.world,
            seed: self.seed,
            result: Verdict::Failed,
            time_s: 0.0,
            travelled_m: 0.0,
            min_clearance_m: None,
            optimal_time_s: self.optimal_time_s,
            score: 0.0,
            fault: Some(fault.to_owned()),
            decision_p50_ms: None,
            decision_p99_ms: None,
        }
    }

    const fn unsound(&self, error: SimError) -> BarnError {
        BarnError::Sim {
            world: self.world,
            error,
        }
    }
}
