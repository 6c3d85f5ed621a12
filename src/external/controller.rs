//! A controller that is a program.

use std::time::{Duration, Instant};

use super::protocol::{
    GridMessage, PROTOCOL, Request, Robot, Role, ScanMessage, Start, Tick, Velocity, Want,
};
use super::{NoAnswer, Program, ProgramSettings, REASON_CHARACTERS, shown};
use crate::geometry::{Point, Twist};
use crate::global::Path;
use crate::map::ObstacleGrid;
use crate::navigator::{
    Controller, ControllerError, ControllerInput, ControllerReply, Fault, NavigatorSettings,
    RobotModel,
};

/// A program that returns a velocity at each tick.
pub struct ProcessController {
    program: Program,
    /// The map, if the program wants it and has not got it yet.
    map: Option<GridMessage>,
    /// The path, if it is new.
    path: Option<Vec<Point>>,
    is_reset: bool,
    ticks: u64,
    /// Longest time of an answer; none in simulated time.
    budget: Option<Duration>,
    /// Time that the program has had for an answer which is still due.
    late: Option<Duration>,
}

crate::settings::opaque_debug!(ProcessController);

impl ProcessController {
    /// Starts the program for a robot with this control period, in seconds, on a map. With a deadline an answer that takes longer is late:
    /// it is dropped when it comes. Without one the robot waits for each answer.
    ///
    /// # Errors
    /// When the program cannot be started or its first answer is wrong.
    pub fn start(
        settings: &ProgramSettings,
        robot: &RobotModel,
        period_s: f64,
        navigator: &NavigatorSettings,
        map: &ObstacleGrid,
    ) -> Result<Self, Fault> {
        let NavigatorSettings {
            deadline_s: budget_s, xy_goal_tolerance, yaw_goal_tolerance, ..
        } = *navigator;
        let first = Request::Start(Start {
            protocol: PROTOCOL,
            role: Role::Controller,
            period_s,
            budget_s,
            goal_tolerance: Some([xy_goal_tolerance, yaw_goal_tolerance]),
            robot: Robot::new(&robot.footprint, &robot.limits),
        });
        let program = Program::start(settings, &first).map_err(|reason| Fault::Controller {
            name: settings.to_string(),
            error: ControllerError::Failed { reason },
        })?;
        let wants_map = program.wants.contains(&Want::Map);
        Ok(Self {
            map: wants_map.then(|| GridMessage::of_grid(map)),
            program,
            path: None,
            is_reset: false,
            ticks: 0,
            budget: budget_s.map(Duration::from_secs_f64),
            late: None,
        })
    }

    /// The velocity of an answer for which the program had this time.
    fn velocity(&mut self, answer: Result<Velocity, NoAnswer>, limit: Duration) -> ControllerReply {
        match answer {
            Ok(Velocity::Velocity { linear, angular }) => {
                self.late = None;
                Ok(Twist::new(linear, angular))
            }
            Ok(Velocity::Error { error }) => {
                self.late = None;
                let reason = shown(&error, REASON_CHARACTERS);
                Err(ControllerError::NoValidControl { reason })
            }
            Err(error @ (NoAnswer::Failed(_) | NoAnswer::Interrupted)) => {
                Err(ControllerError::Failed { reason: self.program.reason(error) })
            }
            Err(NoAnswer::Silent) => {
                let waited = self.late.unwrap_or_default() + limit;
                self.late = Some(waited);
                if waited < self.program.timeout {
                    return Err(ControllerError::Late);
                }
                Err(ControllerError::TimedOut { after_s: self.program.timeout.as_secs_f64() })
            }
        }
    }

    /// Waits for the answer to an earlier tick, if it is due. It is for a place that the robot has left: a velocity or a reason
    /// against one is dropped.
    fn drop_late_answer(&mut self, limit: Duration) -> Result<(), ControllerError> {
        if self.late.is_none() {
            return Ok(());
        }
        let answer = self.program.answer(limit);
        match self.velocity(answer, limit) {
            Ok(_) | Err(ControllerError::NoValidControl { .. }) => Ok(()),
            Err(error) => Err(error),
        }
    }
}

impl Controller for ProcessController {
    fn name(&self) -> &str {
        &self.program.name
    }

    fn set_plan(&mut self, path: &Path) {
        self.path = Some(path.points().to_vec());
    }

    fn compute_velocity(&mut self, input: &ControllerInput<'_>) -> ControllerReply {
        let began = Instant::now();
        let limit = self.budget.unwrap_or(self.program.timeout);
        self.drop_late_answer(limit)?;
        let wants = |want| self.program.wants.contains(&want);
        let moving_obstacles = wants(Want::MovingObstacles).then_some(input.moving_obstacles);
        let local_grid = wants(Want::LocalGrid).then(|| GridMessage::of_field(input.local_grid));
        let map = self.map.take();
        let tick = Tick {
            tick: self.ticks,
            time_s: input.time_s,
            pose: input.pose,
            twist: input.twist,
            odometry_s: input.odometry_s,
            predicted_pose: input.predicted_pose,
            predicted_twist: input.predicted_twist,
            last_command: input.last_command,
            limits: input.limits,
            goal: *input.goal,
            local_target: input.local_target,
            path: self.path.take(),
            path_progress_m: input.path_progress_m,
            reset: core::mem::take(&mut self.is_reset),
            scan: ScanMessage::new(input.scan),
            scan_s: input.scan_s,
            moving_obstacles,
            local_grid,
            map: map.as_ref(),
        };
        // The wait for the late answer is part of this tick's budget.
        let left = self.budget.map_or(limit, |budget| budget.saturating_sub(began.elapsed()));
        let answer = self.program.ask(&Request::Tick(Box::new(tick)), left);
        self.ticks += 1;
        self.velocity(answer, left)
    }

    fn reset(&mut self) {
        self.is_reset = true;
    }

    fn finish(&mut self) -> Result<(), ControllerError> {
        self.program.finish::<Velocity>().map_err(|reason| ControllerError::Failed { reason })
    }
}
