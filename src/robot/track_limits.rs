//! Limits of the individual tracks.

use serde::{Deserialize, Serialize};

use super::{RobotError, TrackSpeeds};
use crate::settings::{Setting, require, settings};

settings! {
    /// Limits of each track. They apply after the conversion from forward speed and turn rate.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct TrackLimits {
        /// Largest speed of a track in both directions. Default 1.25 m/s: the outer track of a base 0.5 m wide at the
        /// default top speed and turn rate.
        pub max_track_speed: f64 = 1.25, ["m/s", above 0];
        /// Largest acceleration of a track. Default 1.5 m/s^2: the default forward and angular acceleration combined,
        /// 1.0 m/s^2 and 2.0 rad/s^2 on a base 0.5 m wide.
        pub acc_lim_track: f64 = 1.5, ["m/s^2", above 0];
        /// Largest deceleration of a track, negative as in Nav2. Default -1.5 m/s^2, equal to the acceleration.
        pub decel_lim_track: f64 = -1.5, ["m/s^2", below 0];
        /// Smallest speed of a moving track, below `max_track_speed`. Default 0.02 m/s: our choice for geared
        /// motors, which stick or jerk below it.
        pub deadband: f64 = 0.02, ["m/s", at_least 0];
    }
}

impl TrackLimits {
    /// Validates all limits.
    ///
    /// # Errors
    /// Names the first limit that is not finite or has the wrong sign.
    pub fn validate(&self) -> Result<(), RobotError> {
        self.check_ranges()?;
        Ok(require(
            self.deadband < self.max_track_speed,
            "deadband",
            self.deadband,
            "finite, at least zero and below max_track_speed",
        )?)
    }

    /// Scales both speeds by the same factor to at most the largest, which keeps the curvature (eq. 11).
    #[must_use]
    pub fn scale_to_max(&self, target: &TrackSpeeds) -> TrackSpeeds {
        let fastest = target.left.abs().max(target.right.abs());
        if fastest <= self.max_track_speed {
            return *target;
        }
        let factor = self.max_track_speed / fastest;
        // Rounding may leave the product one ulp above the limit.
        let keep = |speed: f64| (speed * factor).clamp(-self.max_track_speed, self.max_track_speed);
        TrackSpeeds { left: keep(target.left), right: keep(target.right) }
    }

    /// The speeds nearest to the target that the tracks can reach from the current ones within a time, seconds.
    ///
    /// Both changes are scaled by the factor of the slower track, so that both tracks reach their targets together. A start
    /// from standstill has the target's curvature throughout, and a stop takes no longer.
    #[must_use]
    pub fn reachable(
        &self,
        current: &TrackSpeeds,
        target: &TrackSpeeds,
        time_s: f64,
    ) -> TrackSpeeds {
        let factor = |from: f64, to: f64| {
            let change = (to - from).abs();
            let max = self.max_change(from, to, time_s);
            if change > max { max / change } else { 1.0 }
        };
        let factor = factor(current.left, target.left).min(factor(current.right, target.right));
        if factor >= 1.0 {
            return *target;
        }
        TrackSpeeds {
            left: current.left + factor * (target.left - current.left),
            right: current.right + factor * (target.right - current.right),
        }
    }

    /// The largest change of a track's speed towards another within a time: a reversal first decelerates to zero.
    fn max_change(&self, from: f64, to: f64, time_s: f64) -> f64 {
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

    /// Sets speeds within the deadband to zero.
    ///
    /// Speeds are not raised to the deadband, as motor drivers do for voltages: the base would move faster than commanded, and
    /// on noise alone. The planner reads the resulting standstill from the encoder.
    #[must_use]
    pub fn apply_deadband(&self, speeds: &TrackSpeeds) -> TrackSpeeds {
        let keep = |speed: f64| {
            if speed.abs() < self.deadband { 0.0 } else { speed }
        };
        TrackSpeeds { left: keep(speeds.left), right: keep(speeds.right) }
    }

    /// The longest time to standstill, seconds.
    #[must_use]
    pub fn max_stopping_time_s(&self) -> f64 {
        self.max_track_speed / -self.decel_lim_track
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
    fn scale_to_max_keeps_the_ratio() {
        assert_eq!(LIMITS.scale_to_max(&tracks(0.8, 1.6)), tracks(0.5, 1.0));
        assert_eq!(LIMITS.scale_to_max(&tracks(-4.0, 2.0)), tracks(-1.0, 0.5));
        assert_eq!(LIMITS.scale_to_max(&tracks(0.8, 0.9)), tracks(0.8, 0.9));
    }

    #[test]
    fn reachable_keeps_the_curvature_at_start_and_the_stopping_time() {
        // 0.1 s at 1 m/s^2 is 0.1 m/s for the right track, and half of it for the left.
        let started = LIMITS.reachable(&tracks(0.0, 0.0), &tracks(0.4, 0.8), 0.1);
        assert!((started.left - 0.05).abs() < 1e-12 && (started.right - 0.1).abs() < 1e-12);
        // 0.1 s at 2 m/s^2 is a fourth of the right track's 0.8 m/s.
        let braked = LIMITS.reachable(&tracks(0.4, 0.8), &tracks(0.0, 0.0), 0.1);
        assert!((braked.left - 0.3).abs() < 1e-12 && (braked.right - 0.6).abs() < 1e-12);
        let stopped = LIMITS.reachable(&tracks(0.4, 0.8), &tracks(0.0, 0.0), 0.4);
        assert_eq!(stopped, tracks(0.0, 0.0));
    }

    #[test]
    fn reversal_decelerates_before_it_accelerates() {
        // 0.1 s to stop from 0.2 m/s at 2 m/s^2; then 0.1 s at 1 m/s^2 gives 0.1 m/s.
        let turned = LIMITS.reachable(&tracks(0.2, 0.2), &tracks(-1.0, -1.0), 0.2);
        assert!((turned.left + 0.1).abs() < 1e-12 && (turned.right + 0.1).abs() < 1e-12);
    }

    #[test]
    fn speeds_within_the_deadband_become_zero() {
        assert_eq!(LIMITS.apply_deadband(&tracks(0.049, -0.05)), tracks(0.0, -0.05));
    }

    #[test]
    fn track_limits_reject_bad_values_by_name() {
        for (limits, start) in [
            (TrackLimits { max_track_speed: 0.0, ..LIMITS }, "max_track_speed is 0"),
            (TrackLimits { acc_lim_track: f64::NAN, ..LIMITS }, "acc_lim_track is NaN"),
            (TrackLimits { decel_lim_track: 1.0, ..LIMITS }, "decel_lim_track is 1"),
            (TrackLimits { deadband: 1.0, ..LIMITS }, "deadband is 1"),
        ] {
            let message = limits.validate().unwrap_err().to_string();
            assert!(message.starts_with(start), "{message}");
        }
        TrackLimits::default().validate().expect("valid limits");
    }
}
