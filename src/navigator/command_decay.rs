//! Decay of the last command while no new decision is in time.

use crate::geometry::Twist;
use crate::robot::Limits;

/// A command that is not renewed decays to zero within this time, seconds: Nav2's `failure_tolerance`, three ticks at 10 Hz.
/// An obstacle at 1.5 m/s comes 0.45 m nearer in this time.
pub const COMMAND_LIFETIME_S: f64 = 0.3;

/// The last timely command, and the share of it that was sent last.
///
/// The command sent is `command * share`. The share is 1 for a new command, falls linearly with its age, and is 0 from
/// [`COMMAND_LIFETIME_S`] on. Speed and turn rate decay together, so the robot stays on the arc that was found clear. Where
/// either would fall faster than the base can brake, both fall at the braking limit.
#[derive(Clone, Copy, Debug)]
pub(super) struct CommandDecay {
    command: Twist,
    decided_s: f64,
    share: f64,
}

impl Default for CommandDecay {
    /// No decision yet: stand.
    fn default() -> Self {
        Self { command: Twist::STOP, decided_s: f64::NEG_INFINITY, share: 0.0 }
    }
}

impl CommandDecay {
    /// Takes a command decided at a time, seconds.
    pub const fn renew(&mut self, time_s: f64, command: Twist) {
        *self = Self { command, decided_s: time_s, share: 1.0 };
    }

    /// The command to send at a time, `period_s` after the last one, both in seconds. It never grows, even if the clock goes
    /// back.
    pub fn at(&mut self, time_s: f64, period_s: f64, limits: &Limits) -> Twist {
        let fresh = 1.0 - (time_s - self.decided_s) / COMMAND_LIFETIME_S;
        // A time that is not a number makes the command worth nothing.
        let wanted = if fresh > 0.0 { fresh } else { 0.0 };
        let fall = |speed: f64, brake: f64| match speed.abs() {
            0.0 => f64::INFINITY,
            size => -brake * period_s / size,
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

    fn limits(brake_x: f64, brake_theta: f64) -> Limits {
        Limits { decel_lim_x: -brake_x, decel_lim_theta: -brake_theta, ..Limits::default() }
    }

    /// The commands sent at the ticks after a decision.
    fn sent(command: Twist, limits: &Limits, ticks: i32) -> Vec<Twist> {
        let mut decay = CommandDecay::default();
        decay.renew(7.0, command);
        (1..=ticks)
            .map(|tick| decay.at(7.0 + f64::from(tick) * PERIOD_S, PERIOD_S, limits))
            .collect()
    }

    #[test]
    fn command_decays_linearly_to_zero() {
        let sent = sent(Twist::new(0.6, -0.3), &limits(9.0, 9.0), 8);
        for (expected, sent) in [0.5, 0.4, 0.3, 0.2, 0.1, 0.0, 0.0, 0.0].iter().zip(sent) {
            assert!((sent.linear - expected).abs() < 1e-12, "{sent:?}");
            assert!((sent.angular + expected / 2.0).abs() < 1e-12, "{sent:?}");
        }
    }

    #[test]
    fn decay_keeps_the_arc_and_the_braking_limit() {
        // 1 m/s^2 is 0.05 m/s per tick, a tenth of 0.5 m/s; the turn rate could lose a sixth.
        let sent = sent(Twist::new(0.5, 0.3), &limits(1.0, 1.0), 12);
        for (tick, sent) in (1..).zip(sent) {
            let expected = (0.5 - 0.05 * f64::from(tick)).max(0.0);
            assert!((sent.linear - expected).abs() < 1e-12, "{tick}: {sent:?}");
            assert!((sent.angular - 0.6 * expected).abs() < 1e-12, "{sent:?}");
        }
    }

    #[test]
    fn decayed_command_never_grows_and_a_bad_time_stops_it() {
        let limits = limits(9.0, 9.0);
        let mut decay = CommandDecay::default();
        assert_eq!(decay.at(0.0, PERIOD_S, &limits), Twist::STOP);
        decay.renew(7.0, Twist::new(0.6, 0.0));
        let half = decay.at(7.15, PERIOD_S, &limits).linear;
        assert!((half - 0.3).abs() < 1e-12);
        assert_eq!(decay.at(6.0, PERIOD_S, &limits).linear, half);
        assert_eq!(decay.at(f64::NAN, PERIOD_S, &limits), Twist::STOP);
        assert_eq!(decay.at(7.15, PERIOD_S, &limits), Twist::STOP);
    }
}
