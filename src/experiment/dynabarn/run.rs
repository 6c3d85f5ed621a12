//! One run: moving cylinders, a robot with an empty map, and the rules.

use std::sync::Arc;

use super::{Body, Culprit, DynaBarnRow, DynaBarnWorld, Hindsight, State};
use crate::experiment::worlds::{RunFigures, RunKey, WorldError, WorldTask};
use crate::geometry::Point;
use crate::map::{GridFrame, MapError, MovingDisc, OccupancyGrid};
use crate::navigator::Goal;
use crate::runtime::{Config, Mission, MissionResult, TraceRow};
use crate::sim::{MovingObstacle, MovingObstacles, Simulation};

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

impl WorldTask for Task<'_> {
    type Row = DynaBarnRow;

    fn key(&self) -> RunKey {
        RunKey {
            world: self.world.number,
            seed: self.seed,
        }
    }

    /// An empty map, on which nothing stands in truth either, and what moves.
    fn simulation(&self) -> Result<Simulation, WorldError> {
        let DynaBarnWorld {
            number,
            start,
            goal,
            bodies,
        } = self.world;
        let world = *number;
        let map = field(self.world).map_err(|error| WorldError::Ground { world, error })?;
        let moving = bodies.iter().map(|body| {
            // It takes no notice of the robot.
            MovingObstacle::timed_path(body.radius_m, body.script.clone())
        });
        let moving = moving
            .collect::<Result<_, _>>()
            .map_err(|error| WorldError::Sim { world, error })?;
        let goal = Goal {
            position: *goal,
            yaw: None,
        };
        Ok(Simulation {
            moving_obstacles: MovingObstacles::new(moving),
            seed: self.seed,
            ..Simulation::new(Mission {
                time_limit_s: TIME_LIMIT_S,
                done_within_m: Some(GOAL_RADIUS_M),
                ..Mission::new(Arc::new(map), *start, goal)
            })
        })
    }

    fn row(
        &self,
        config: &Config,
        figures: RunFigures,
        result: Option<&MissionResult>,
    ) -> DynaBarnRow {
        let blame = |result| self.culprit(result, config);
        DynaBarnRow {
            world: self.world.number,
            seed: self.seed,
            result: figures.verdict,
            blame: result.map_or(Culprit::Nobody, blame),
            time_s: figures.time_s,
            travelled_m: figures.travelled_m,
            min_clearance_m: figures.min_clearance_m,
            plans: result.map_or(0, |result| result.plans.len() as u64),
            fault: figures.fault,
            decision_p50_ms: figures.decision_p50_ms,
            decision_p99_ms: figures.decision_p99_ms,
        }
    }
}

impl Task<'_> {
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
}

/// Empty ground with room about all that happens on it.
fn field(world: &DynaBarnWorld) -> Result<OccupancyGrid, MapError> {
    let ends = [world.start.position(), world.goal];
    let keys = world.bodies.iter().flat_map(|body| body.script.keys());
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

const fn state(row: &TraceRow) -> State {
    State {
        time_s: row.time_s,
        pose: row.pose,
        twist: row.twist,
    }
}
