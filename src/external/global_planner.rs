//! A global planner that is a program.

use super::protocol::{
    GridMessage, PROTOCOL, PathRequest, PlannedPath, Request, Robot, Role, Start,
};
use super::{Program, ProgramSettings, SHOWN_CHARACTERS};
use crate::geometry::Point;
use crate::global::{Path, Plan, PlanError};
use crate::map::{MovingDisc, ObstacleGrid};
use crate::navigator::{GlobalPlanner, RobotModel};

/// Largest distance of the ends of a path from start and goal, metres. A program may plan between centres of cells.
const END_TOLERANCE_M: f64 = 0.25;
/// Distance between two checked points of a path, cells.
const CHECK_STEP_CELLS: f64 = 0.5;

/// A program that plans paths.
pub struct ProcessPlanner {
    program: Program,
    least_radius_m: f64,
}

impl ProcessPlanner {
    /// Starts the program for a robot whose path is to keep this distance from obstacles, metres. The control period, seconds, is
    /// for the program's information.
    ///
    /// # Errors
    /// When the program cannot be started or its first answer is wrong.
    pub fn start(
        settings: &ProgramSettings,
        robot: &RobotModel,
        period_s: f64,
        least_radius_m: f64,
    ) -> Result<Self, PlanError> {
        let first = Request::Start(Start {
            protocol: PROTOCOL,
            role: Role::GlobalPlanner,
            period_s,
            budget_s: None,
            robot: Robot::new(&robot.footprint, &robot.limits),
        });
        let program = Program::start(settings, &first)
            .map_err(|reason| PlanError::InvalidPlanner { name: settings.to_string(), reason })?;
        Ok(Self { program, least_radius_m })
    }

    fn invalid(&self, reason: String) -> PlanError {
        PlanError::InvalidPlanner { name: self.program.name.clone(), reason }
    }

    /// The path of an answer, with exact ends, if the robot can follow it.
    fn checked(
        &self,
        mut points: Vec<Point>,
        obstacles: &ObstacleGrid,
        ends: [Point; 2],
    ) -> Result<Path, PlanError> {
        let [start, goal] = ends;
        if points.len() < 2 || points.iter().any(|point| !point.is_finite()) {
            return Err(self.invalid("a path has at least two points, all finite".to_owned()));
        }
        let last = points.len() - 1;
        for (index, end, name) in [(0, start, "start"), (last, goal, "goal")] {
            let off_m = (points[index] - end).norm();
            if off_m > END_TOLERANCE_M {
                return Err(self.invalid(format!(
                    "the path ends {off_m:.2} m from the {name}; at most {END_TOLERANCE_M} m are allowed"
                )));
            }
            points[index] = end;
        }
        let path = Path::new(points);
        let frame = obstacles.frame();
        let is_blocked =
            |point: &Point| frame.cell_of(point).is_none_or(|cell| obstacles.is_blocked(cell));
        let step_m = CHECK_STEP_CELLS * frame.resolution_m;
        let blocked = path.samples(step_m).find(is_blocked);
        if let Some(Point { x, y }) = blocked {
            return Err(self.invalid(format!("the path crosses an obstacle at ({x:.2}, {y:.2})")));
        }
        Ok(path)
    }
}

impl GlobalPlanner for ProcessPlanner {
    fn plan(
        &mut self,
        obstacles: &ObstacleGrid,
        _transient: &[MovingDisc],
        start: Point,
        goal: Point,
        clock: &mut dyn FnMut() -> f64,
    ) -> Result<Plan, PlanError> {
        let grid = GridMessage::of_grid(obstacles);
        let radius_m = self.least_radius_m;
        let began_s = clock();
        self.program.send(&Request::Plan(PathRequest { start, goal, radius_m, grid: &grid }));
        let timeout = self.program.timeout;
        let answer = self.program.answer(timeout);
        let planned = answer.map_err(|error| self.invalid(self.program.reason(error)))?;
        let took_s = clock() - began_s;
        match planned {
            PlannedPath::Path(path) => {
                let path = self.checked(path, obstacles, [start, goal])?;
                let mut plan = Plan::of_path(path, radius_m);
                plan.time_s.search = took_s;
                Ok(plan)
            }
            PlannedPath::Error(why) => {
                let why = why.as_str().map_or_else(|| why.to_string(), str::to_owned);
                let shown: String = why.chars().take(SHOWN_CHARACTERS).collect();
                let reason = format!("{}: {}", self.program.name, shown.escape_debug());
                Err(PlanError::NoValidPath {
                    start,
                    goal,
                    radius_m,
                    expanded: 0,
                    nearest: None,
                    reason: Some(reason),
                })
            }
        }
    }

    fn least_radius_m(&self) -> f64 {
        self.least_radius_m
    }
}
