//! The simulation of a world, and the cause of a contact in it.

use std::sync::Arc;

use super::{ContactAttribution, DynaBarnWorld, ScriptedCylinder, State};
use crate::experiment::{ContactCause, RunError};
use crate::geometry::Point;
use crate::map::{GridFrame, MapError, MovingDisc, OccupancyGrid};
use crate::navigator::Goal;
use crate::runtime::{Config, Mission, MissionResult, TraceRow};
use crate::sim::{MovingObstacle, MovingObstacles, Simulation};

/// The goal is reached when the true pose is this close to it, metres: the rule of the BARN Challenge.
const GOAL_RADIUS_M: f64 = 1.0;
/// A run ends after this time, seconds: also that challenge's rule.
const TIME_LIMIT_S: f64 = 100.0;
/// Side of a cell of the robot's map, metres.
const RESOLUTION_M: f64 = 0.05;
/// Free margin around start, goal and all keyframes, metres; the border beyond it is solid.
const MARGIN_M: f64 = 3.0;

impl DynaBarnWorld {
    /// The simulation of a seed: an empty map, which is also the truth, and the moving cylinders.
    ///
    /// # Errors
    /// Fails when the world is too large for a grid, or a cylinder cannot move as described.
    pub fn simulation(&self, seed: u64) -> Result<Simulation, RunError> {
        let map = empty_map(self)?;
        let moving = self.cylinders.iter().map(|cylinder| {
            // It ignores the robot.
            MovingObstacle::timed_path(cylinder.radius_m, cylinder.script.clone())
        });
        let moving = moving.collect::<Result<Vec<_>, _>>()?;
        let goal = Goal { position: self.goal, yaw: None };
        Ok(Simulation {
            moving_obstacles: MovingObstacles::new(moving),
            seed,
            ..Simulation::new(Mission {
                time_limit_s: TIME_LIMIT_S,
                done_within_m: Some(GOAL_RADIUS_M),
                ..Mission::new(Arc::new(map), self.start, goal)
            })
        })
    }

    /// The cause of the contact that ended a run; none without contact.
    pub(in crate::experiment) fn contact_cause(
        &self,
        result: &MissionResult,
        config: &Config,
    ) -> Option<ContactCause> {
        let rows = &result.trace.rows;
        let last = rows.last().filter(|_| result.collided)?;
        let footprint = &config.robot.footprint;
        let attribution = ContactAttribution {
            footprint,
            limits: &config.robot.limits,
            moving: &|time_s| self.moving(time_s),
        };
        let states: Vec<State> = rows.iter().map(state).collect();
        let contact = state(last);
        let is_touched = |disc: &MovingDisc| {
            let gap_m = footprint.gap_to_disc_m(&last.pose, &disc.center(), disc.radius);
            // The simulator's clock is a sum over many ticks and has a rounding error.
            gap_m <= 1e-6
        };
        let before = ContactAttribution::before(&states, &contact);
        let touched = self.moving(last.time_s).iter().any(is_touched);
        Some(match before.filter(|_| touched) {
            Some(before) => attribution.cause(before, &contact),
            None => ContactCause::Robot,
        })
    }

    /// The true positions of the cylinders at a time, seconds.
    fn moving(&self, time_s: f64) -> Vec<MovingDisc> {
        let at = |cylinder: &ScriptedCylinder| cylinder.at(time_s);
        self.cylinders.iter().map(at).collect()
    }
}

/// An empty map with a margin around everything that happens on it.
fn empty_map(world: &DynaBarnWorld) -> Result<OccupancyGrid, MapError> {
    let ends = [world.start.position(), world.goal];
    let keys = world.cylinders.iter().flat_map(|it| it.script.keys());
    let mut low = Point::new(f64::INFINITY, f64::INFINITY);
    let mut high = -low;
    for place in keys.map(|key| key.1).chain(ends) {
        low = low.inf(&place);
        high = high.sup(&place);
    }
    let cells = |from: f64, to: f64| ((to - from + 2.0 * MARGIN_M) / RESOLUTION_M).ceil() as i32;
    let frame = GridFrame::new(
        cells(low.x, high.x),
        cells(low.y, high.y),
        RESOLUTION_M,
        [low.x - MARGIN_M, low.y - MARGIN_M, 0.0].into(),
    )?;
    Ok(OccupancyGrid::new(frame, vec![0; frame.len()]))
}

const fn state(row: &TraceRow) -> State {
    State { time_s: row.time_s, pose: row.pose, twist: row.twist }
}
