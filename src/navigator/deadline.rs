//! Decisions in time: what is sent in place of a late one, and how densely the next one samples.

use serde::Serialize;

use super::{AdaptiveSampling, CommandDecay, Decision, Navigator, Observation};
use crate::geometry::Twist;
use crate::local::{LocalSettings, Sampling};
use crate::robot::Limits;

/// Watches over decisions. Holds no clock: what a decision took is told.
#[derive(Clone, Debug)]
pub struct Deadline {
    limit_s: f64,
    period_s: f64,
    limits: Limits,
    fading: CommandDecay,
    density: AdaptiveSampling,
    decisions: u64,
    misses: u64,
}

/// How punctual decisions were.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DeadlineStats {
    /// The deadline, seconds.
    pub deadline_s: f64,
    /// Decisions taken.
    pub decisions: u64,
    /// Those that took longer.
    pub misses: u64,
    /// The lowest density on the way.
    pub lowest: Sampling,
    /// The density at the end.
    pub last: Sampling,
}

impl Deadline {
    /// For decisions that may take so many seconds, with the density of these settings, for a base with these limits.
    #[must_use]
    pub fn new(limit_s: f64, settings: &LocalSettings, limits: &Limits) -> Self {
        Self {
            limit_s,
            period_s: settings.control_period_s,
            limits: *limits,
            fading: CommandDecay::default(),
            density: AdaptiveSampling::new(settings.sampling()),
            decisions: 0,
            misses: 0,
        }
    }

    /// What to send at a tick, of which the observation is of `time_s` and the decision took `took_s`, both in seconds: the
    /// decision, or where it is late the last one that was not, as [`CommandDecay`] has it. A late decision is never sent: it
    /// is for where the robot was thought to be by then.
    pub fn settle(&mut self, time_s: f64, took_s: f64, decided: Twist) -> Twist {
        self.decisions += 1;
        let share = took_s / self.limit_s;
        self.density.note(share);
        if share <= 1.0 {
            self.fading.renew(time_s, decided);
            return decided;
        }
        self.misses += 1;
        self.fading.at(time_s, self.period_s, &self.limits)
    }

    /// How densely to sample at the next tick.
    #[must_use]
    pub fn sampling(&self) -> Sampling {
        self.density.sampling()
    }

    /// The counts so far.
    #[must_use]
    pub fn stats(&self) -> DeadlineStats {
        DeadlineStats {
            deadline_s: self.limit_s,
            decisions: self.decisions,
            misses: self.misses,
            lowest: self.density.lowest(),
            last: self.density.sampling(),
        }
    }
}

impl Navigator {
    /// Decides as [`Self::step`] does, by a clock in seconds, and says how many it took. With a `deadline_s` in the settings
    /// the command is the one to send at a tick that may be late, and the next tick samples as densely as it can.
    pub fn step_by(
        &mut self,
        observation: &Observation,
        clock: &mut dyn FnMut() -> f64,
    ) -> (Decision, f64) {
        let began_s = clock();
        let mut decision = self.step(observation);
        let took_s = clock() - began_s;
        if let Some(deadline) = &mut self.deadline {
            decision.command = deadline.settle(observation.time_s, took_s, decision.command);
            self.planner.set_sampling(deadline.sampling());
            self.last_command = decision.command;
        }
        (decision, took_s)
    }

    /// Whether decisions came in time; none without a deadline.
    #[must_use]
    pub fn deadline_stats(&self) -> Option<DeadlineStats> {
        self.deadline.as_ref().map(Deadline::stats)
    }
}
