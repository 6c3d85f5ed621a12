//! What to send while no new decision comes: the last one, fading.

use crate::geometry::Twist;
use crate::robot::Limits;

/// A plan that is not renewed is worth nothing after so long, seconds: Nav2's `failure_tolerance`, three ticks at 10 Hz.
/// Something that steps out at 1.5 m/s has come 0.45 m nearer by then.
pub const COMMAND_LIFETIME_S: f64 = 0.3;

/// The last command that came in time, and the share of it that was sent last.
///
/// Sent is `command * share`: 1 when the command is new, less with its age in a straight line, 0 from [`COMMAND_LIFETIME_S`] on.
/// Speed and turn rate fade together, so the robot stays on the arc that was found clear; where either would have to fall
/// faster than the base can brake, both fall as fast as it can.
#[derive(Clone, Copy, Debug)]
pub struct CommandDecay {
    command: Twist,
    decided_s: f64,
    share: f64,
}

impl Default for CommandDecay {
    /// Nothing was ever decided: stand.
    fn default() -> Self {
        Self {
            command: Twist::STOP,
            decided_s: f64::NEG_INFINITY,
            share: 0.0,
        }
    }
}

impl CommandDecay {
    /// Takes a command decided at a time, seconds.
    pub const fn renew(&mut self, time_s: f64, command: Twist) {
        *self = Self {
            command,
            decided_s: time_s,
            share: 1.0,
        };
    }

    /// What to send at a time, `period_s` after the last that was sent, both in seconds. It never grows, not even where
    /// the clock goes back.
    pub fn at(&mut self, time_s: f64, period_s: f64, limits: &Limits) -> Twist {
        let fresh = 1.0 - (time_s - self.decided_s) / COMMAND_LIFETIME_S;
        // A time that is not a number makes the plan worth nothing.
        let wanted = if fresh > 0.0 { fresh } else { 0.0 };
        let fall = |speed: f64, brake: f64| match speed.abs() {
            0.0 => f64::INFINITY,
            size => -brake * period_s / size,
        };
        let most = fall(self.command.linear, limits.decel_lim_x)
            .min(fall(self.command.angular, limits.decel_lim_theta));
        self.share = self.share.min(wanted.max(self.share - most));
        Twist::new(
            self.command.linear * self.share,
            self.command.angular * self.share,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD_S: f64 = 0.05;

    fn limits(brake_x: f64, brake_theta: f64) -> Limits {
        Limits {
            decel_lim_x: -brake_x,
            decel_lim_theta: -brake_theta,
            ..Limits::default()
        }
    }

    /// What is sent at so many ticks after a command.
    fn sent(command: Twist, limits: &Limits, ticks: i32) -> Vec<Twist> {
        let mut fading = CommandDecay::default();
        fading.renew(7.0, command);
        (1..=ticks)
            .map(|tick| fading.at(7.0 + f64::from(tick) * PERIOD_S, PERIOD_S, limits))
            .collect()
    }

    #[test]
    fn it_falls_in_a_straight_line_to_zero_at_the_age_of_a_plan() {
        let sent = sent(Twist::new(0.6, -0.3), &limits(9.0, 9.0), 8);
        for (expected, sent) in [0.5, 0.4, 0.3, 0.2, 0.1, 0.0, 0.0, 0.0].iter().zip(sent) {
            assert!((sent.linear - expected).abs() < 1e-12, "{sent:?}");
            assert!((sent.angular + expected / 2.0).abs() < 1e-12, "{sent:?}");
        }
    }

    #[test]
    fn where_the_base_cannot_brake_so_hard_both_fall_at_its_limit_on_the_same_arc() {
        // 1 m/s^2 takes 0.05 m/s off at a tick, a tenth of 0.5 m/s; in turn rate a sixth could go.
        let sent = sent(Twist::new(0.5, 0.3), &limits(1.0, 1.0), 12);
        for (tick, sent) in (1..).zip(sent) {
            let expected = (0.5 - 0.05 * f64::from(tick)).max(0.0);
            assert!((sent.linear - expected).abs() < 1e-12, "{tick}: {sent:?}");
            assert!((sent.angular - 0.6 * expected).abs() < 1e-12, "{sent:?}");
        }
    }

    #[test]
    fn it_never_grows_and_no_bad_time_keeps_it_alive() {
        let limits = limits(9.0, 9.0);
        let mut fading = CommandDecay::default();
        assert_eq!(fading.at(0.0, PERIOD_S, &limits), Twist::STOP);
        fading.renew(7.0, Twist::new(0.6, 0.0));
        let half = fading.at(7.15, PERIOD_S, &limits).linear;
        assert!((half - 0.3).abs() < 1e-12);
        assert_eq!(fading.at(6.0, PERIOD_S, &limits).linear, half);
        assert_eq!(fading.at(f64::NAN, PERIOD_S, &limits), Twist::STOP);
        assert_eq!(fading.at(7.15, PERIOD_S, &limits), Twist::STOP);
    }
}
