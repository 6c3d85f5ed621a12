//! The local planner: window, problem, engine, command.

use std::sync::Arc;

use super::{
    ClearanceField, Detail, Engine, EngineError, Evaluation, Fan, Incidents, LocalSettings,
    Prepared, Problem, ProblemError, Sampling, Weights, Window,
};
use crate::geometry::{Point, Pose, Twist};
use crate::map::MovingDisc;
use crate::robot::{Footprint, Limits};

/// What the robot knows at a tick.
#[derive(Clone, Debug)]
pub struct Situation<'a> {
    /// Static obstacles around the robot.
    pub field: &'a Arc<ClearanceField>,
    /// Where it is.
    pub pose: Pose,
    /// How fast it moves.
    pub twist: Twist,
    /// Moving obstacles.
    pub obstacles: &'a [MovingDisc],
    /// Where to face: the local target.
    pub target: Point,
    /// The key node to end near.
    pub key_node: Point,
    /// What the robot may do at this tick.
    pub limits: Limits,
    /// The shape to keep clear.
    pub footprint: &'a Footprint,
    /// How much each term counts.
    pub weights: Weights,
}

impl Situation<'_> {
    /// The problem that it poses to a planner with these settings, whose weights it replaces by its own.
    #[must_use]
    pub fn problem(&self, settings: &LocalSettings) -> Problem {
        self.problem_with(settings, self.footprint.clone(), Vec::new())
    }

    /// The same problem in the memory of one no longer needed: nothing is allocated for a footprint that has not
    /// changed and for moving obstacles that the old one had room for.
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

/// A decision that could not be taken.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ChooseError {
    /// The situation is outside the promised ranges.
    #[error(transparent)]
    Problem(#[from] ProblemError),
    /// The engine gave no answer.
    #[error(transparent)]
    Engine(#[from] EngineError),
}

/// Chooses a velocity from the dynamic window, many times a second.
pub struct LocalPlanner {
    engine: Box<dyn Engine>,
    settings: LocalSettings,
    /// The last decision's, kept for its memory: with it the next one allocates nothing. It keeps that decision's field
    /// alive as well.
    last: Option<(Problem, Prepared)>,
    /// What the engine answered to it; none where it failed.
    answer: Option<Evaluation>,
}

impl LocalPlanner {
    /// A planner on an engine.
    #[must_use]
    pub fn new(engine: Box<dyn Engine>, settings: LocalSettings) -> Self {
        Self {
            engine,
            settings,
            last: None,
            answer: None,
        }
    }

    /// What the engine runs on.
    #[must_use]
    pub fn engine_name(&self) -> String {
        self.engine.name()
    }

    /// What an engine with a stand-in has met so far; none for one without.
    #[must_use]
    pub fn incidents(&self) -> Option<&Incidents> {
        self.engine.incidents()
    }

    /// Samples as densely as this from now on.
    pub const fn set_sampling(&mut self, sampling: Sampling) {
        self.settings.vx_samples = sampling.vx_samples;
        self.settings.vtheta_samples = sampling.vtheta_samples;
    }

    /// At most so many samples along each axis of the last decision, for people to look at; none before the first, and none
    /// where the engine failed.
    #[must_use]
    pub fn fan(&self, most: Sampling) -> Option<Fan> {
        let (problem, prepared) = self.last.as_ref()?;
        Some(Fan::new(problem, prepared, self.answer.as_ref()?, most))
    }

    /// Sampling, horizon and weights.
    #[must_use]
    pub const fn settings(&self) -> &LocalSettings {
        &self.settings
    }

    /// Evaluates the window; the command is the winner's velocity, none when no sample is admissible.
    ///
    /// # Errors
    /// When the situation is out of range or the engine fails.
    pub fn choose(
        &mut self,
        situation: &Situation<'_>,
    ) -> Result<(Option<Twist>, Evaluation), ChooseError> {
        let (problem, prepared) = match self.last.take() {
            None => {
                let problem = situation.problem(&self.settings);
                let prepared = Prepared::new(&problem)?;
                (problem, prepared)
            }
            Some((problem, prepared)) => {
                let problem = situation.problem_in(problem, &self.settings);
                let prepared = prepared.refilled(&problem)?;
                (problem, prepared)
            }
        };
        let evaluation = self.engine.evaluate(&prepared, Detail::Answer);
        let window = problem.window;
        self.last = Some((problem, prepared));
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
