//! The local planner: window, problem, engine, command.

use super::{
    DecisionError, DecisionInput, Detail, Engine, Evaluation, Incidents, LocalSettings, Problem,
    QuantizedProblem, Sampling, TrajectoryFan,
};
use crate::geometry::Twist;
use crate::robot::{Limits, TickTime};

/// The cap of the clearance is not raised further than this, metres.
const MAX_RAISED_CLEARANCE_M: f64 = 3.0;

/// Chooses a velocity from the dynamic window at every control tick.
pub struct LocalPlanner {
    engine: Box<dyn Engine>,
    settings: LocalSettings,
    tick: TickTime,
    /// The last problem. The next decision reuses its memory and allocates nothing; its field stays alive until then.
    last: Option<(Problem, QuantizedProblem)>,
    /// The answer to it; `None` when the engine failed.
    answer: Option<Evaluation>,
}

crate::settings::opaque_debug!(LocalPlanner);

impl LocalPlanner {
    /// Creates a planner that owns its engine.
    #[must_use]
    pub fn new(engine: Box<dyn Engine>, settings: LocalSettings) -> Self {
        let tick = settings.control_period_s.into();
        Self { engine, settings, tick, last: None, answer: None }
    }

    /// Name of the engine, see [`Engine::name`].
    #[must_use]
    pub fn engine_name(&self) -> String {
        self.engine.name()
    }

    /// GPU failures so far, see [`Engine::incidents`].
    #[must_use]
    pub fn incidents(&self) -> Option<Incidents> {
        self.engine.incidents()
    }

    /// Sets the sampling density of the following decisions.
    pub const fn set_sampling(&mut self, sampling: Sampling) {
        self.settings.vx_samples = sampling.vx_samples;
        self.settings.vtheta_samples = sampling.vtheta_samples;
    }

    /// Raises the cap of the clearance of the following decisions, up to 3 m, to the distance in which a robot with these limits stops from
    /// its highest speed or turn rate: otherwise eq. 30 would limit its speed.
    pub(crate) fn permit_speeds_of(&mut self, limits: &Limits) {
        let needed_m = self.settings.clearance_to_stop_m(limits).min(MAX_RAISED_CLEARANCE_M);
        self.settings.max_clearance_m = self.settings.max_clearance_m.max(needed_m);
    }

    /// Sets the time between two checked poses of the following decisions, seconds.
    pub(crate) const fn set_step(&mut self, step_s: f64) {
        self.settings.sim_step_s = step_s;
    }

    /// Sets the horizon of the following decisions, seconds.
    pub(crate) const fn set_horizon(&mut self, horizon_s: f64) {
        self.settings.sim_time_s = horizon_s;
    }

    /// Sets the time since the tick before, by which a late decision may brake further. It is one control period at first.
    pub const fn set_tick_time(&mut self, tick: TickTime) {
        self.tick = tick;
    }

    /// At most `max` samples along each axis of the last decision, for display. `None` before the first decision and
    /// after one in which the engine failed.
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
        let (old, quantized) = self.last.take().unzip();
        let problem = input.problem_in(old, &self.settings, self.tick);
        let quantized = match quantized {
            None => QuantizedProblem::new(&problem)?,
            Some(quantized) => quantized.requantized(&problem)?,
        };
        let evaluation = self.engine.evaluate(&quantized, Detail::Answer);
        self.last = Some((problem, quantized));
        self.answer = None;
        let evaluation = evaluation?;
        self.answer = Some(evaluation.clone());
        let command = evaluation.winner.as_ref().and_then(|winner| {
            self.last.as_ref().map(|(problem, _)| problem.command(winner.index))
        });
        Ok((command, evaluation))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::local::{CpuEngine, Stopping};

    #[test]
    fn cap_of_the_clearance_permits_the_highest_speeds_up_to_a_limit() {
        let cap_m = |stopping: Stopping, limits: Limits| {
            let settings = LocalSettings { stopping, ..LocalSettings::default() };
            let mut planner = LocalPlanner::new(Box::new(CpuEngine::single_threaded()), settings);
            planner.permit_speeds_of(&limits);
            planner.settings.max_clearance_m
        };
        let default = Limits::default();
        for (limits, expected_m) in [
            (default, 1.5),
            (Limits { max_vel_x: 2.0, ..default }, 2.0),
            (Limits { min_vel_x: -2.2, ..default }, 2.42),
            (Limits { max_vel_theta: 3.0, ..default }, 2.25),
            (Limits { max_vel_x: 10.0, ..default }, 3.0),
        ] {
            let raised_m = cap_m(Stopping::Clearance, limits);
            assert!((raised_m - expected_m).abs() < 1e-9, "{raised_m} m, not {expected_m}");
            assert!((cap_m(Stopping::Arc, limits) - 1.5).abs() < 1e-9);
        }
    }
}
