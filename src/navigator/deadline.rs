//! Deadline of a decision: what to send instead of a late one, and how densely the next one samples.

use serde::Serialize;

use super::adaptive_sampling::AdaptiveSampling;
use super::command_decay::CommandDecay;
use crate::geometry::Twist;
use crate::local::{LocalSettings, Sampling};
use crate::robot::Limits;

/// Checks decisions against their deadline. Holds no clock: the caller measures.
#[derive(Clone, Debug)]
pub(super) struct Deadline {
    limit_s: f64,
    period_s: f64,
    limits: Limits,
    decay: CommandDecay,
    sampling: AdaptiveSampling,
    decisions: u64,
    misses: u64,
}

/// How many decisions met their deadline.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct DeadlineStats {
    /// The deadline, seconds.
    pub deadline_s: f64,
    /// Number of decisions.
    pub decisions: u64,
    /// Number of late decisions.
    pub misses: u64,
    /// The lowest sampling density so far.
    pub lowest: Sampling,
    /// The sampling density at the end.
    pub last: Sampling,
}

impl Deadline {
    /// A deadline in seconds for decisions with these settings, on a base with these limits.
    pub fn new(limit_s: f64, settings: &LocalSettings, limits: &Limits) -> Self {
        Self {
            limit_s,
            period_s: settings.control_period_s,
            limits: *limits,
            decay: CommandDecay::default(),
            sampling: AdaptiveSampling::new(settings.sampling()),
            decisions: 0,
            misses: 0,
        }
    }

    /// Returns the command to send, for an observation at `time_s` and a decision that took `took_s`, both in seconds. A late
    /// decision is for a place that the robot has left: the last timely one is sent instead, decayed.
    pub fn settle(&mut self, time_s: f64, took_s: f64, decided: Twist) -> Twist {
        self.decisions += 1;
        let share = took_s / self.limit_s;
        self.sampling.update(share);
        if share <= 1.0 {
            self.decay.renew(time_s, decided);
            return decided;
        }
        self.misses += 1;
        self.decay.at(time_s, self.period_s, &self.limits)
    }

    /// The sampling density for the next tick.
    pub fn sampling(&self) -> Sampling {
        self.sampling.sampling()
    }

    /// The counts so far.
    pub fn stats(&self) -> DeadlineStats {
        DeadlineStats {
            deadline_s: self.limit_s,
            decisions: self.decisions,
            misses: self.misses,
            lowest: self.sampling.lowest(),
            last: self.sampling.sampling(),
        }
    }
}
