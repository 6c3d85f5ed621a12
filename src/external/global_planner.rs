//! A global planner that is a program.

use super::protocol::{
    GridMessage, PROTOCOL, PathRequest, PlannedPath, Request, Robot, Role, Start,
};
use super::{NoAnswer, Program, ProgramSettings, REASON_CHARACTERS, shown};
use crate::geometry::Point;
use crate::global::{Path, Plan, PlanError};
use crate::map::{MovingDisc, ObstacleGrid};
use crate::navigator::{END_TOLERANCE_M, GlobalPlanner, RobotModel, check_cells, check_ends};

/// A program that plans paths.
pub struct ProcessPlanner {
    program: Program,
    least_radius_m: f64,
    /// Number of requests so far.
    requests: u64,
}

crate::settings::opaque_debug!(ProcessPlanner);

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
            goal_tolerance: None,
            robot: Robot::new(&robot.footprint, &robot.limits),
        });
        let program = Program::start(settings, &first)
            .map_err(|reason| PlanError::InvalidPlanner { name: settings.to_string(), reason })?;
        Ok(Self { program, least_radius_m, requests: 0 })
    }

    fn invalid(&self, reason: String) -> PlanError {
        PlanError::InvalidPlanner { name: self.program.name.clone(), reason }
    }

    /// The path of an answer, with exact ends, if the robot can follow it.
    fn checked(
        &self,
        mut points: Vec<Point>,
        obstacles: &ObstacleGrid,
        [start, goal]: [Point; 2],
    ) -> Result<Path, PlanError> {
        if points.len() < 2 {
            return Err(self.invalid("a path has at least two points".to_owned()));
        }
        check_ends(&points, [start, goal], END_TOLERANCE_M).map_err(|why| self.invalid(why))?;
        let last = points.len() - 1;
        (points[0], points[last]) = (start, goal);
        let path = Path::new(points);
        check_cells(&path, obstacles).map_err(|why| self.invalid(why))?;
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
        let number = self.requests;
        self.requests += 1;
        let request =
            Request::Plan(PathRequest { request: number, start, goal, radius_m, grid: &grid });
        let answer = self.program.ask(&request, self.program.timeout);
        let planned = answer.map_err(|error| match error {
            NoAnswer::Interrupted => PlanError::Interrupted { name: self.program.name.clone() },
            error => self.invalid(self.program.reason(error)),
        })?;
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
                let reason =
                    format!("by {}: {}", self.program.name, shown(&why, REASON_CHARACTERS));
                Err(PlanError::NoValidPath {
                    start,
                    goal,
                    radius_m,
                    turning_radius_m: None,
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

    fn is_external(&self) -> bool {
        true
    }

    fn finish(&mut self) -> Result<(), PlanError> {
        self.program.finish::<PlannedPath>().map_err(|reason| self.invalid(reason))
    }
}
