//! One run: moving cylinders, a robot with an empty map, and the rules.

use std::sync::Arc;

use super::{Body, Culprit, DynaBarnError, DynaBarnRow, DynaBarnWorld, Hindsight, State};
use crate::bench::Latencies;
use crate::bench::barn::Verdict;
use crate::geometry::Point;
use crate::local::CpuEngine;
use crate::map::{GridFrame, MapError, MovingDisc, OccupancyGrid};
use crate::navigator::Goal;
use crate::sim::{
    Config, Mission, MissionError, MissionResult, Moving, Observer, SimError, TraceRow, Walkers,
    run_mission,
};

/// The goal is reached when the true pose is within this of it, metres: the rule of the BARN Challenge.
const GOAL_RADIUS_M: f64 = 1.0;
/// A run ends after this long, seconds: that challenge's rule again.
const TIME_LIMIT_S: f64 = 100.0;
/// Side of a cell of the robot's map, metres.
const RESOLUTION_M: f64 = 0.05;
/// Free ground about the ends and every place that a cylinder comes to, metres; the border beyond it is solid.
const ROOM_M: f64 = 3.0;

/// What is to be driven.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Task<'w> {
    /// The world.
    pub world: &'w DynaBarnWorld,
    /// Seed of the noise.
    pub seed: u64,
}

impl Task<'_> {
    /// The mission of this run: an empty map, on which nothing stands in truth either, and what moves.
    ///
    /// # Errors
    /// When the world is too large for a grid, or a cylinder cannot move as told.
    pub fn mission(&self) -> Result<Mission, DynaBarnError> {
        let DynaBarnWorld {
            number,
            start,
            goal,
            bodies,
        } = self.world;
        let world = *number;
        let map = field(self.world).map_err(|error| DynaBarnError::Ground { world, error })?;
        let moving = bodies.iter().map(|body| {
            // Straight from key to key, and no notice taken of the robot.
            Moving::keyframes(body.radius_m, &body.keys, Some(body.loop_s))
        });
        let moving = moving
            .collect::<Result<_, _>>()
            .map_err(|error| self.unsound(error))?;
        let goal = Goal {
            position: *goal,
            yaw: None,
        };
        Ok(Mission {
            walkers: Walkers::new(moving),
            seed: self.seed,
            time_limit_s: TIME_LIMIT_S,
            done_within_m: Some(GOAL_RADIUS_M),
            ..Mission::new(Arc::new(map), *start, goal)
        })
    }
}

/// Empty ground with room about all that happens on it.
fn field(world: &DynaBarnWorld) -> Result<OccupancyGrid, MapError> {
    let ends = [world.start.position(), world.goal];
    let keys = world.bodies.iter().flat_map(|body| &body.keys);
    let mut low = Point::new(f64::INFINITY, f64::INFINITY);
    let mut high = -low;
    for place in keys.map(|key| key.1).chain(ends) {
        low = low.inf(&place);
        high = high.sup(&place);
    }
    let cells = |from: f64, to: f64| ((to - from + 2.0 * ROOM_M) / RESOLUTION_M).ceil() as i32;
    let frame = GridFrame::new(
        cells(low.x, high.x),
        cells(low.y, high.y),
        RESOLUTION_M,
        [low.x - ROOM_M, low.y - ROOM_M, 0.0].into(),
    )?;
    Ok(OccupancyGrid::new(frame, vec![0; frame.len()]))
}

/// Drives, on one thread; times each decision by `clock`, in seconds. Without a result where the navigator found no way
/// to begin with.
///
/// # Errors
/// When the world is too large, or the configuration is not sound.
pub fn drive(
    task: &Task<'_>,
    config: &Config,
    clock: &mut dyn FnMut() -> f64,
) -> Result<(DynaBarnRow, Option<MissionResult>), DynaBarnError> {
    let mission = task.mission()?;
    let engine = Box::new(CpuEngine::single_threaded());
    let mut observer = Observer {
        clock,
        progress: &mut |_| {},
    };
    match run_mission(&mission, config, engine, &mut observer) {
        Ok(result) => Ok((task.row(&result, config), Some(result))),
        Err(MissionError::Fault(fault)) => Ok((task.refused(&fault.to_string()), None)),
        Err(MissionError::Sim(error)) => Err(task.unsound(error)),
    }
}

impl Task<'_> {
    fn row(&self, result: &MissionResult, config: &Config) -> DynaBarnRow {
        let mut times = Latencies::default();
        for &seconds in &result.decision_s {
            // A clock that ran backwards would give no time.
            let _ = times.record(seconds);
        }
        let times = times.summary();
        DynaBarnRow {
            world: self.world.number,
            seed: self.seed,
            result: Verdict::of(result),
            blame: self.culprit(result, config),
            time_s: result.time_s,
            travelled_m: result.travelled_m,
            min_clearance_m: Some(result.min_clearance_m).filter(|gap_m| gap_m.is_finite()),
            plans: result.plans.len() as u64,
            fault: result.fault.as_ref().map(ToString::to_string),
            decision_p50_ms: times.map(|times| times.p50_ms),
            decision_p99_ms: times.map(|times| times.p99_ms),
        }
    }

    /// Whose the contact was that ended the run.
    fn culprit(&self, result: &MissionResult, config: &Config) -> Culprit {
        let rows = &result.trace.rows;
        let Some(last) = rows.last().filter(|_| result.collided) else {
            return Culprit::Nobody;
        };
        let footprint = &config.robot.footprint;
        let hindsight = Hindsight {
            footprint,
            limits: &config.robot.limits,
            moving: &|time_s| self.moving(time_s),
        };
        let states: Vec<State> = rows.iter().map(state).collect();
        let contact = state(last);
        let runs_into = |disc: &MovingDisc| {
            let gap_m = footprint.gap_to_disc_m(&last.pose, &disc.center(), disc.radius);
            // The walkers' clock, a sum of many ticks, is off by its rounding.
            gap_m <= 1e-6
        };
        match Hindsight::before(&states, &contact) {
            Some(before) if self.moving(last.time_s).iter().any(runs_into) => {
                hindsight.blame(before, &contact).into()
            }
            _ => Culprit::Robot,
        }
    }

    /// Where everything truly is at a time, seconds.
    fn moving(&self, time_s: f64) -> Vec<MovingDisc> {
        let at = |body: &Body| body.at(time_s);
        self.world.bodies.iter().map(at).collect()
    }

    fn refused(&self, fault: &str) -> DynaBarnRow {
        DynaBarnRow {
            world: self.world.number,
            seed: self.seed,
            result: Verdict::Failed,
            blame: Culprit::Nobody,
            time_s: 0.0,
            travelled_m: 0.0,
            min_clearance_m: None,
            plans: 0,
            fault: Some(fault.to_owned()),
            decision_p50_ms: None,
            decision_p99_ms: None,
        }
    }

    const fn unsound(&self, error: SimError) -> DynaBarnError {
        DynaBarnError::Sim {
            world: self.world.number,
            error,
        }
    }
}

const fn state(row: &TraceRow) -> State {
    State {
        time_s: row.time_s,
        pose: row.pose,
        twist: row.twist,
    }
}
