//! Deadline of a decision: what to send instead of a late one, and how densely the next one samples.

use serde::Serialize;

use crate::geometry::Twist;
use crate::local::{LocalSettings, Sampling};
use crate::robot::{Limits, TickTime};

/// A command that is not renewed decays to zero within this time, seconds: Nav2's `failure_tolerance`, three ticks at 10 Hz.
/// An obstacle at 1.5 m/s comes 0.45 m nearer in this time.
#[doc(hidden)]
pub const COMMAND_LIFETIME_S: f64 = 0.3;

/// This many misses of the remembered decisions lower the sampling density: a single one may be the system's fault.
const MISSES_TO_LOWER: u32 = 2;
/// Number of decisions whose misses are remembered: a second at 10 Hz.
const MISSES_REMEMBERED: u32 = 10;
/// A decision within this share of its deadline has slack: the next level has at most four times the samples.
const SLACK: f64 = 0.25;
/// This many decisions in a row with slack raise the sampling density: five seconds at 10 Hz.
const SLACK_TO_RAISE: u32 = 50;
/// No level has fewer forward speeds or turn rates, unless the settings have: the closed loop was measured with 64 samples and
/// more.
const FEWEST: u32 = 8;

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

/// Checks decisions against their deadline. Holds no clock: the caller measures.
#[derive(Clone, Debug)]
pub(super) struct Deadline {
    limits: Limits,
    decay: CommandDecay,
    /// Levels of sampling density: that of the settings first, and half as many speeds and turn rates at each further one.
    levels: Vec<Sampling>,
    level: usize,
    /// One bit for each of the last decisions, the newest in the lowest bit: whether it was late.
    late: u32,
    with_slack: u32,
    stats: DeadlineStats,
}

impl Deadline {
    /// A deadline in seconds for decisions with these settings, on a base with these limits.
    pub fn new(deadline_s: f64, settings: &LocalSettings, limits: &Limits) -> Self {
        let full = settings.sampling();
        let half = |count: u32| count.min(FEWEST).max(count.div_ceil(2));
        let below = |above: &Sampling| {
            let next = Sampling {
                vx_samples: half(above.vx_samples),
                vtheta_samples: half(above.vtheta_samples),
            };
            (next != *above).then_some(next)
        };
        Self {
            limits: *limits,
            decay: CommandDecay::default(),
            levels: core::iter::successors(Some(full), below).collect(),
            level: 0,
            late: 0,
            with_slack: 0,
            stats: DeadlineStats { deadline_s, decisions: 0, misses: 0, lowest: full, last: full },
        }
    }

    /// Returns the command to send, for an observation at `time_s`, the time since the tick before, and a decision that took
    /// `took_s`, in seconds. A late decision is for a place that the robot has left: the last timely one is sent instead, decayed.
    pub fn settle(&mut self, time_s: f64, tick: TickTime, took_s: f64, decided: Twist) -> Twist {
        self.stats.decisions += 1;
        let share = took_s / self.stats.deadline_s;
        self.adapt_sampling(share);
        if share <= 1.0 {
            self.decay = CommandDecay { command: decided, decided_s: time_s, share: 1.0 };
            return decided;
        }
        self.stats.misses += 1;
        self.decay.at(time_s, tick.braking_s(), &self.limits)
    }

    /// The counts so far; `last` is the sampling density for the next tick.
    pub const fn stats(&self) -> DeadlineStats {
        self.stats
    }

    /// Updates the level with a decision that took this share of its deadline; above 1 it was late.
    fn adapt_sampling(&mut self, share: f64) {
        let is_late = share > 1.0 || share.is_nan();
        self.late = (self.late << 1 | u32::from(is_late)) & ((1 << MISSES_REMEMBERED) - 1);
        self.with_slack = if share <= SLACK { self.with_slack + 1 } else { 0 };
        self.level = if self.late.count_ones() >= MISSES_TO_LOWER {
            (self.level + 1).min(self.levels.len() - 1)
        } else if self.with_slack >= SLACK_TO_RAISE {
            self.level.saturating_sub(1)
        } else {
            return;
        };
        // The decisions at one level say nothing about the next.
        (self.late, self.with_slack) = (0, 0);
        let (last, lowest) = (self.levels[self.level], self.stats.lowest);
        self.stats.last = last;
        self.stats.lowest = Sampling {
            vx_samples: last.vx_samples.min(lowest.vx_samples),
            vtheta_samples: last.vtheta_samples.min(lowest.vtheta_samples),
        };
    }
}

/// The last timely command, and the share of it that was sent last.
///
/// The command sent is `command * share`. The share is 1 for a new command, falls linearly with its age, and is 0 from
/// [`COMMAND_LIFETIME_S`] on. Speed and turn rate decay together, so the robot stays on the arc that was found clear. Where
/// either would fall faster than the base can brake, both fall at the braking limit. Before the first decision the share is 0.
#[derive(Clone, Copy, Debug, Default)]
struct CommandDecay {
    command: Twist,
    decided_s: f64,
    share: f64,
}

impl CommandDecay {
    /// The command to send at a time, `elapsed_s` after the last one, both in seconds. It never grows, even if the clock goes
    /// back.
    fn at(&mut self, time_s: f64, elapsed_s: f64, limits: &Limits) -> Twist {
        let fresh = 1.0 - (time_s - self.decided_s) / COMMAND_LIFETIME_S;
        // A time that is not a number makes the command worth nothing.
        let wanted = if fresh > 0.0 { fresh } else { 0.0 };
        let fall = |speed: f64, brake: f64| match speed.abs() {
            0.0 => f64::INFINITY,
            size => -brake * elapsed_s / size,
        };
        let most = fall(self.command.linear, limits.decel_lim_x)
            .min(fall(self.command.angular, limits.decel_lim_theta));
        self.share = self.share.min(wanted.max(self.share - most));
        Twist::new(self.command.linear * self.share, self.command.angular * self.share)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD_S: f64 = 0.05;

    /// A base whose braking limits are these, at its first tick after a timely command.
    fn decided(command: Twist, brake: f64) -> Deadline {
        let limits = Limits { decel_lim_x: -brake, decel_lim_theta: -brake, ..Limits::default() };
        let settings = LocalSettings { control_period_s: PERIOD_S, ..LocalSettings::default() };
        let mut deadline = Deadline::new(1.0, &settings, &limits);
        assert_eq!(late(&mut deadline, 0.0), Twist::STOP, "there is no decision yet");
        assert_eq!(deadline.settle(7.0, PERIOD_S.into(), 0.5, command), command);
        deadline
    }

    fn late(deadline: &mut Deadline, time_s: f64) -> Twist {
        deadline.settle(time_s, PERIOD_S.into(), 1.5, Twist::new(1.0, 1.0))
    }

    fn ticks(count: i32) -> impl Iterator<Item = f64> {
        (1..=count).map(|tick| 7.0 + f64::from(tick) * PERIOD_S)
    }

    #[test]
    fn command_decays_linearly_to_zero() {
        let mut deadline = decided(Twist::new(0.6, -0.3), 9.0);
        for (expected, time_s) in [0.5, 0.4, 0.3, 0.2, 0.1, 0.0, 0.0, 0.0].iter().zip(ticks(8)) {
            let sent = late(&mut deadline, time_s);
            assert!((sent.linear - expected).abs() < 1e-12, "{sent:?}");
            assert!((sent.angular + expected / 2.0).abs() < 1e-12, "{sent:?}");
        }
    }

    #[test]
    fn decay_keeps_the_arc_and_the_braking_limit() {
        // 1 m/s^2 is 0.05 m/s per tick, a tenth of 0.5 m/s; the turn rate could lose a sixth.
        let mut deadline = decided(Twist::new(0.5, 0.3), 1.0);
        for (tick, time_s) in (1..).zip(ticks(12)) {
            let sent = late(&mut deadline, time_s);
            let expected = (0.5 - 0.05 * f64::from(tick)).max(0.0);
            assert!((sent.linear - expected).abs() < 1e-12, "{tick}: {sent:?}");
            assert!((sent.angular - 0.6 * expected).abs() < 1e-12, "{sent:?}");
        }
    }

    #[test]
    fn decayed_command_never_grows_and_a_bad_time_stops_it() {
        let mut deadline = decided(Twist::new(0.6, 0.0), 9.0);
        let half = late(&mut deadline, 7.15).linear;
        assert!((half - 0.3).abs() < 1e-12);
        assert_eq!(late(&mut deadline, 6.0).linear, half);
        assert_eq!(late(&mut deadline, f64::NAN), Twist::STOP);
        assert_eq!(late(&mut deadline, 7.15), Twist::STOP);
    }
}
