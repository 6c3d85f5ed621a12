//! What a track can do, and what is made of speeds that it cannot.

use serde::{Deserialize, Serialize};

use super::{PerTrack, RobotError, TrackSpeeds};
use crate::documented::documented;

documented! {
    /// The limits of each track alone, which hold after the mixing of speed and turn rate.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct TrackLimits {
        /// Highest speed of a track either way, m/s, above zero. Default 1.25 m/s: what the default limits of the robot ask
        /// of the outer track of a base 0.5 m wide, at top speed and top turn rate.
        pub max_track_speed: f64,
        /// Highest gain of a track's speed, m/s^2, above zero. Default 1.5 m/s^2: the default gain of forward speed and of
        /// turn rate at once, 1.0 m/s^2 and 2.0 rad/s^2 on a base 0.5 m wide.
        pub acc_lim_track: f64,
        /// Hardest braking of a track, m/s^2, below zero, in Nav2's sign for braking. Default -1.5 m/s^2, as the gain.
        pub decel_lim_track: f64,
        /// Speed below which a track stands, m/s, at least zero and below `max_track_speed`. Default 0.02 m/s: our own
        /// choice for geared motors, which stick or jerk below it.
        pub deadband: f64,
    }
}

impl Default for TrackLimits {
    fn default() -> Self {
        Self {
            max_track_speed: 1.25,
            acc_lim_track: 1.5,
            decel_lim_track: -1.5,
            deadband: 0.02,
        }
    }
}

impl TrackLimits {
    /// Checks every number.
    ///
    /// # Errors
    /// Names the first limit that is not finite or has the wrong sign.
    pub fn validate(&self) -> Result<(), RobotError> {
        let deadband = self.deadband >= 0.0 && self.deadband < self.max_track_speed;
        for (name, value, good, expected) in [
            (
                "max_track_speed",
                self.max_track_speed,
                self.max_track_speed > 0.0,
                "finite and above zero",
            ),
            (
                "acc_lim_track",
                self.acc_lim_track,
                self.acc_lim_track > 0.0,
                "finite and above zero",
            ),
            (
                "decel_lim_track",
                self.decel_lim_track,
                self.decel_lim_track < 0.0,
                "finite and below zero (Nav2's sign for braking)",
            ),
            (
                "deadband",
                self.deadband,
                deadband,
                "finite, at least zero and below max_track_speed",
            ),
        ] {
            if !(value.is_finite() && good) {
                return Err(RobotError::BadLimit {
                    name,
                    value,
                    expected,
                });
            }
        }
        Ok(())
    }

    /// The speeds within the highest: both are scaled alike, so that the curvature of the way (eq. 11) stays.
    #[must_use]
    pub fn within(&self, wanted: &TrackSpeeds) -> TrackSpeeds {
        let fastest = wanted.left.abs().max(wanted.right.abs());
        if fastest <= self.max_track_speed {
            return *wanted;
        }
        let share = self.max_track_speed / fastest;
        // Dividing first and multiplying then may end an ulp above the limit.
        let keep = |speed: f64| (speed * share).clamp(-self.max_track_speed, self.max_track_speed);
        TrackSpeeds {
            left: keep(wanted.left),
            right: keep(wanted.right),
        }
    }

    /// The speeds nearest to those wanted that the tracks reach from their present ones within a time in seconds.
    ///
    /// Both changes are cut by the same share, that of the track which needs it most, so that both arrive together: from
    /// a standstill the curvature is the wanted one all the way, and a stop takes no longer for it.
    #[must_use]
    pub fn reachable(
        &self,
        current: &TrackSpeeds,
        wanted: &TrackSpeeds,
        time_s: f64,
    ) -> TrackSpeeds {
        let share = |from: f64, to: f64| {
            let change = (to - from).abs();
            let most = self.most_change(from, to, time_s);
            if change > most { most / change } else { 1.0 }
        };
        let share = share(current.left, wanted.left).min(share(current.right, wanted.right));
        if share >= 1.0 {
            return *wanted;
        }
        TrackSpeeds {
            left: current.left + share * (wanted.left - current.left),
            right: current.right + share * (wanted.right - current.right),
        }
    }

    /// The greatest change of a track's speed on its way to another: braking to zero first where it must.
    fn most_change(&self, from: f64, to: f64, time_s: f64) -> f64 {
        let away_from_zero = from == 0.0 || (to - from) * from > 0.0;
        if away_from_zero {
            return self.acc_lim_track * time_s;
        }
        let to_zero_s = from.abs() / -self.decel_lim_track;
        if time_s <= to_zero_s {
            -self.decel_lim_track * time_s
        } else {
            from.abs() + self.acc_lim_track * (time_s - to_zero_s)
        }
    }

    /// The speeds with those within the deadband made zero.
    ///
    /// Not lifted to the deadband, as drivers of a motor's voltage do: a base then moved faster than it was told, and by
    /// noise alone. A track that cannot turn so slowly only heats its motor; and its encoder, not the command, tells
    /// the planner that it stands.
    #[must_use]
    pub fn without_deadband(&self, speeds: &TrackSpeeds) -> TrackSpeeds {
        let keep = |speed: f64| {
            if speed.abs() < self.deadband {
                0.0
            } else {
                speed
            }
        };
        TrackSpeeds {
            left: keep(speeds.left),
            right: keep(speeds.right),
        }
    }

    /// The longest time, seconds, from any speeds of the tracks to standstill.
    #[must_use]
    pub fn max_stopping_time_s(&self) -> f64 {
        self.max_track_speed / -self.decel_lim_track
    }
}

impl From<TrackSpeeds> for PerTrack<f64> {
    fn from(speeds: TrackSpeeds) -> Self {
        Self::new(speeds.left, speeds.right)
    }
}

impl From<PerTrack<f64>> for TrackSpeeds {
    fn from(speeds: PerTrack<f64>) -> Self {
        Self {
            left: speeds.left,
            right: speeds.right,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: TrackLimits = TrackLimits {
        max_track_speed: 1.0,
        acc_lim_track: 1.0,
        decel_lim_track: -2.0,
        deadband: 0.05,
    };

    fn tracks(left: f64, right: f64) -> TrackSpeeds {
        TrackSpeeds { left, right }
    }

    #[test]
    fn too_fast_a_pair_keeps_its_ratio() {
        assert_eq!(LIMITS.within(&tracks(0.8, 1.6)), tracks(0.5, 1.0));
        assert_eq!(LIMITS.within(&tracks(-4.0, 2.0)), tracks(-1.0, 0.5));
        assert_eq!(LIMITS.within(&tracks(0.8, 0.9)), tracks(0.8, 0.9));
    }

    #[test]
    fn a_start_keeps_the_wanted_curvature_and_a_stop_is_as_quick_as_the_faster_track() {
        // 0.1 s at 1 m/s^2 is 0.1 m/s for the right track; the left has half of it.
        let started = LIMITS.reachable(&tracks(0.0, 0.0), &tracks(0.4, 0.8), 0.1);
        assert!((started.left - 0.05).abs() < 1e-12 && (started.right - 0.1).abs() < 1e-12);
        // 0.1 s at 2 m/s^2 is a fourth of the right track's 0.8 m/s.
        let braked = LIMITS.reachable(&tracks(0.4, 0.8), &tracks(0.0, 0.0), 0.1);
        assert!((braked.left - 0.3).abs() < 1e-12 && (braked.right - 0.6).abs() < 1e-12);
        let stopped = LIMITS.reachable(&tracks(0.4, 0.8), &tracks(0.0, 0.0), 0.4);
        assert_eq!(stopped, tracks(0.0, 0.0));
    }

    #[test]
    fn a_reversal_brakes_first_and_gains_then() {
        // 0.1 s to brake 0.2 m/s at 2 m/s^2; the other 0.1 s gain 0.1 m/s at 1 m/s^2.
        let turned = LIMITS.reachable(&tracks(0.2, 0.2), &tracks(-1.0, -1.0), 0.2);
        assert!((turned.left + 0.1).abs() < 1e-12 && (turned.right + 0.1).abs() < 1e-12);
    }

    #[test]
    fn the_deadband_stands() {
        assert_eq!(
            LIMITS.without_deadband(&tracks(0.049, -0.05)),
            tracks(0.0, -0.05)
        );
    }

    #[test]
    fn limits_that_no_track_has_are_refused_by_name() {
        for (limits, words) in [
            (
                TrackLimits {
                    max_track_speed: 0.0,
                    ..LIMITS
                },
                "max_track_speed is 0",
            ),
            (
                TrackLimits {
                    acc_lim_track: f64::NAN,
                    ..LIMITS
                },
                "acc_lim_track is NaN",
            ),
            (
                TrackLimits {
                    decel_lim_track: 1.0,
                    ..LIMITS
                },
                "decel_lim_track is 1",
            ),
            (
                TrackLimits {
                    deadband: 1.0,
                    ..LIMITS
                },
                "deadband is 1",
            ),
        ] {
            let message = limits.validate().unwrap_err().to_string();
            assert!(message.starts_with(words), "{message}");
        }
        TrackLimits::default().validate().expect("sound limits");
    }
}
