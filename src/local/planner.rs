//! The local planner: window, problem, engine, command.

use std::sync::Arc;

use super::{
    ClearanceField, DecisionError, Detail, Engine, Evaluation, Incidents, LocalSettings, Problem,
    QuantizedProblem, Sampling, TrajectoryFan, Weights, Window,
};
use crate::geometry::{Point, Pose, Twist};
use crate::map::MovingDisc;
use crate::robot::{Footprint, Limits};

/// The state of robot and surroundings at a control tick.
#[derive(Clone, Debug)]
pub struct DecisionInput<'a> {
    /// Static obstacles around the robot.
    pub field: &'a Arc<ClearanceField>,
    /// Pose of the robot, map frame.
    pub pose: Pose,
    /// Velocity of the robot.
    pub twist: Twist,
    /// Moving obstacles.
    pub obstacles: &'a [MovingDisc],
    /// The local target: the robot faces it at the end of the horizon.
    pub target: Point,
    /// The key node: the trajectory ends near it.
    pub key_node: Point,
    /// Limits of speed and acceleration at this tick.
    pub limits: Limits,
    /// Shape of the robot.
    pub footprint: &'a Footprint,
    /// Weights of the terms.
    pub weights: Weights,
}

impl DecisionInput<'_> {
    /// The problem for a planner with these settings. The weights of the input replace those of the settings.
    #[must_use]
    pub fn problem(&self, settings: &LocalSettings) -> Problem {
        self.problem_with(settings, self.footprint.clone(), Vec::new())
    }

    /// As [`Self::problem`], in the memory of an old problem: allocates nothing for an unchanged footprint and for moving
    /// obstacles that fit into the old list.
    fn problem_in(&self, old: Problem, settings: &LocalSettings) -> Problem {
        let footprint = if old.footprint == *self.footprint {
            old.footprint
        } else {
            self.footprint.clone()
        };
        self.problem_with(settings, footprint, old.obstacles)
    }

    fn problem_with(
        &self,
        settings: &LocalSettings,
        footprint: Footprint,
        mut obstacles: Vec<MovingDisc>,
    ) -> Problem {
        obstacles.clear();
        obstacles.extend_from_slice(self.obstacles);
        Problem {
            field: Arc::clone(self.field),
            pose: self.pose,
            window: Window::new(
                &self.limits,
                &self.twist,
                settings.control_period_s,
                settings.vx_samples,
                settings.vtheta_samples,
            ),
            braking_x: -self.limits.decel_lim_x,
            braking_theta: -self.limits.decel_lim_theta,
            step_s: settings.sim_step_s,
            steps: settings.steps(),
            footprint,
            max_clearance_m: settings.max_clearance_m,
            outside: settings.outside,
            obstacles,
            target: self.target,
            key_node: self.key_node,
            weights: self.weights,
            normalization: settings.normalization,
            stopping: settings.stopping,
        }
    }
}

/// Chooses a velocity from the dynamic window at every control tick.
pub struct LocalPlanner {
    engine: Box<dyn Engine>,
    settings: LocalSettings,
    /// The last problem. The next decision reuses its memory and allocates nothing; its field stays alive until then.
    last: Option<(Problem, QuantizedProblem)>,
    /// The answer to it; `None` when the engine failed.
    answer: Option<Evaluation>,
}

impl LocalPlanner {
    /// Creates a planner that owns its engine.
    #[must_use]
    pub fn new(engine: Box<dyn Engine>, settings: LocalSettings) -> Self {
        Self {
            engine,
            settings,
            last: None,
            answer: None,
        }
    }

    /// Name of the engine, see [`Engine::name`].
    #[must_use]
    pub fn engine_name(&self) -> String {
        self.engine.name()
    }

    /// GPU failures so far, see [`Engine::incidents`].
    #[must_use]
    pub fn incidents(&self) -> Option<&Incidents> {
        self.engine.incidents()
    }

    /// Sets the sampling density of the following decisions.
    pub const fn set_sampling(&mut self, sampling: Sampling) {
        self.settings.vx_samples = sampling.vx_samples;
        self.settings.vtheta_samples = sampling.vtheta_samples;
    }

    /// At most `max` samples along each axis of the last decision, for display. `None` before the first decision and after
    /// one in which the engine failed.
    #[must_use]
    pub fn trajectory_fan(&self, max: Sampling) -> Option<TrajectoryFan> {
        let (problem, quantized) = self.last.as_ref()?;
        let answer = self.answer.as_ref()?;
        Some(TrajectoryFan::new(problem, quantized, answer, max))
    }

    /// Sampling, horizon and weights.
    #[must_use]
    pub const fn settings(&self) -> &LocalSettings {
        &self.settings
    }

    /// Evaluates the window. The command is the velocity of the winner; `None` when no sample is admissible.
    ///
    /// # Errors
    /// When a quantity is out of range or the engine fails.
    pub fn decide(
        &mut self,
        input: &DecisionInput<'_>,
    ) -> Result<(Option<Twist>, Evaluation), DecisionError> {
        let (problem, quantized) = match self.last.take() {
            None => {
                let problem = input.problem(&self.settings);
                let quantized = QuantizedProblem::new(&problem)?;
                (problem, quantized)
            }
            Some((problem, quantized)) => {
                let problem = input.problem_in(problem, &self.settings);
                let quantized = quantized.requantized(&problem)?;
                (problem, quantized)
            }
        };
        let evaluation = self.engine.evaluate(&quantized, Detail::Answer);
        let window = problem.window;
        self.last = Some((problem, quantized));
        self.answer = None;
        let evaluation = evaluation?;
        self.answer = Some(evaluation.clone());
        let command = evaluation
            .winner
            .as_ref()
            .map(|winner| window.twist(winner.index));
        Ok((command, evaluation))
    }
}
