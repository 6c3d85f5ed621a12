//! Runs a controller in place of the navigator's own behaviours: inputs, answers, and the check for the goal.

use super::condition_timer::ConditionTimer;
use super::controller::{Controller, ControllerError, ControllerInput, ControllerReply};
use super::state::State;
use super::{Decision, Fault, Mode, Observation};
use crate::global::Path;
use crate::map::MovingDisc;

/// A controller with its last answer.
pub(super) struct ControllerHost {
    controller: Box<dyn Controller>,
    reply: Option<ControllerReply>,
    /// Numbers of answers on this leg, and of late ones.
    answers: u32,
    late: u32,
    /// Its reason against every velocity; none if it was late since, or never had one on this leg.
    no_control: Option<String>,
    /// Whether the robot has reached the present goal and brakes.
    has_reached_goal: bool,
    stands: ConditionTimer,
}

impl ControllerHost {
    /// A controller that follows this path first.
    pub fn new(mut controller: Box<dyn Controller>, path: &Path) -> Self {
        controller.set_plan(path);
        Self {
            controller,
            reply: None,
            answers: 0,
            late: 0,
            no_control: None,
            has_reached_goal: false,
            stands: ConditionTimer::default(),
        }
    }

    pub fn name(&self) -> &str {
        self.controller.name()
    }

    /// The answer at the last tick; none where the controller was not asked.
    pub const fn reply(&self) -> Option<&ControllerReply> {
        self.reply.as_ref()
    }

    /// Ends the mission.
    ///
    /// # Errors
    /// As [`Controller::finish`].
    pub fn finish(&mut self) -> Result<(), Fault> {
        let finished = self.controller.finish();
        finished.map_err(|error| Fault::Controller { name: self.name().to_owned(), error })
    }

    /// Forgets the answer of an earlier tick.
    pub fn start_tick(&mut self) {
        self.reply = None;
    }

    /// Follows another path.
    pub fn set_plan(&mut self, path: &Path) {
        self.controller.set_plan(path);
    }

    /// Begins with another goal.
    pub fn start_leg(&mut self, path: &Path) {
        (self.has_reached_goal, self.stands) = (false, ConditionTimer::default());
        (self.answers, self.late, self.no_control) = (0, 0, None);
        self.controller.reset();
        self.controller.set_plan(path);
    }

    /// Why the controller gave no velocity lately, if it did not: its reason, or the share of its late answers.
    pub fn why_blocked(&self) -> Option<String> {
        let (name, late, answers) = (self.name(), self.late, self.answers);
        match &self.no_control {
            Some(reason) => Some(format!("{name}: {reason}")),
            None if late > 0 => Some(format!("{name}: {late} of {answers} answers were late")),
            None => None,
        }
    }

    fn count(&mut self, reply: &ControllerReply) {
        self.answers += 1;
        match reply {
            Err(ControllerError::Late) => {
                self.late += 1;
                self.no_control = None;
            }
            Err(ControllerError::NoValidControl { reason }) => {
                self.no_control = Some(reason.clone());
            }
            _ => {}
        }
    }

    /// Whether the robot is within the tolerances of the goal, or was and brakes since. One that then stands beyond them is not: the
    /// controller goes on.
    pub fn is_at_goal(&mut self, state: &State<'_>) -> bool {
        let is_turned = state.turn_left_rad().is_none();
        let brakes = self.has_reached_goal && !state.measured.stands();
        self.has_reached_goal = brakes || state.is_near_goal() && is_turned;
        if !self.has_reached_goal {
            self.stands = ConditionTimer::default();
        }
        self.has_reached_goal
    }

    /// The decision in a state: the controller's velocity, or braking.
    ///
    /// # Errors
    /// When the controller cannot go on.
    pub fn decide(
        &mut self,
        state: &State<'_>,
        observation: &Observation,
        moving_obstacles: &[MovingDisc],
    ) -> Result<Decision, Fault> {
        let Observation { time_s, pose, twist, odometry_s, scan, scan_s, .. } = observation;
        if state.is_at_goal {
            let is_still = twist.stands();
            let stood_s = self.stands.update(*time_s, is_still);
            let has_stopped = is_still && stood_s >= state.settings.stopped_time_s;
            return Ok(state.stand(if has_stopped { Mode::Arrived } else { Mode::Parking }));
        }
        let input = ControllerInput {
            time_s: *time_s,
            period_s: state.tick.period_s(),
            pose: *pose,
            twist: *twist,
            odometry_s: *odometry_s,
            predicted_pose: state.now.pose,
            predicted_twist: state.now.twist,
            last_command: *state.last_command,
            limits: &state.robot.limits,
            footprint: &state.robot.footprint,
            scan,
            scan_s: *scan_s,
            local_grid: state.field,
            moving_obstacles,
            path: &state.route.path,
            path_progress_m: state.route.progress_m,
            local_target: state.local_target,
            goal: state.goal,
        };
        let reply = self.controller.compute_velocity(&input).and_then(|command| {
            let reason = || "the velocity is not finite".to_owned();
            if command.is_finite() {
                Ok(command)
            } else {
                Err(ControllerError::Failed { reason: reason() })
            }
        });
        self.reply = Some(reply.clone());
        self.count(&reply);
        match reply {
            Ok(command) => Ok(Decision::new(command, Mode::Driving, state.local_target)),
            Err(ControllerError::NoValidControl { .. } | ControllerError::Late) => {
                Ok(state.stand(Mode::Blocked))
            }
            Err(error) => Err(Fault::Controller { name: self.name().to_owned(), error }),
        }
    }
}
