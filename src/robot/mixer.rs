//! Limits of the tracks, and the conversion of commanded twists to track speeds within them.

use serde::{Deserialize, Serialize};

use super::{TickTime, TrackSpeeds, TrackedDrive};
use crate::geometry::Twist;
use crate::settings::{require, settings};

settings! {
    /// Limits of each track. They apply after the conversion from forward speed and turn rate.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct TrackLimits {
        /// Largest speed of a track in both directions. Default 1.25 m/s: the outer track of a base 0.5 m wide at the
        /// default top speed and turn rate.
        pub max_track_speed: f64 = 1.25, ["m/s", above 0 to 10];
        /// Largest acceleration of a track. Default 1.5 m/s^2: the default forward and angular acceleration combined,
        /// 1.0 m/s^2 and 2.0 rad/s^2 on a base 0.5 m wide.
        pub acc_lim_track: f64 = 1.5, ["m/s^2", above 0];
        /// Largest deceleration of a track, negative as in Nav2. Default -1.5 m/s^2, equal to the acceleration.
        pub decel_lim_track: f64 = -1.5, ["m/s^2", below 0];
        /// Smallest speed of a moving track, below `max_track_speed`. Default 0.02 m/s: our choice for geared
        /// motors, which stick or jerk below it.
        pub deadband: f64 = 0.02, ["m/s", at_least 0];
    }
    rule |limits| require(
        limits.deadband < limits.max_track_speed,
        "deadband",
        limits.deadband,
        "finite, at least zero and below max_track_speed",
    )
}

impl TrackLimits {
    /// Scales both speeds by the same factor to at most the largest, which keeps the curvature (eq. 11).
    #[must_use]
    pub fn scale_to_max(&self, target: &TrackSpeeds) -> TrackSpeeds {
        let fastest = target.left.abs().max(target.right.abs());
        if fastest <= self.max_track_speed {
            return *target;
        }
        let factor = self.max_track_speed / fastest;
        // Rounding may leave the product one ulp above the limit.
        let max = self.max_track_speed;
        target.map(|speed| (speed * factor).clamp(-max, max))
    }

    /// The speeds nearest to the target that the tracks can reach from the current ones within a time, seconds, or at a tick of a
    /// control loop.
    ///
    /// Both changes are scaled by the factor of the slower track, so that both tracks reach their targets together. A start
    /// from standstill has the target's curvature throughout, and a stop takes no longer.
    #[must_use]
    pub fn reachable(
        &self,
        current: &TrackSpeeds,
        target: &TrackSpeeds,
        time: impl Into<TickTime>,
    ) -> TrackSpeeds {
        let time = time.into();
        let factor = |from: f64, to: f64| {
            let change = (to - from).abs();
            let max = self.max_change(from, to, &time);
            if change > max { max / change } else { 1.0 }
        };
        let factor = factor(current.left, target.left).min(factor(current.right, target.right));
        if factor >= 1.0 {
            return *target;
        }
        current.zip(*target, |from, to| from + factor * (to - from))
    }

    /// The largest change of a track's speed towards another within a time: a reversal first decelerates to zero.
    fn max_change(&self, from: f64, to: f64, time: &TickTime) -> f64 {
        let away_from_zero = from == 0.0 || (to - from) * from > 0.0;
        if away_from_zero {
            return self.acc_lim_track * time.accelerating_s();
        }
        let to_zero_s = from.abs() / -self.decel_lim_track;
        if time.braking_s() <= to_zero_s {
            -self.decel_lim_track * time.braking_s()
        } else {
            let left_s = (time.braking_s() - to_zero_s).min(time.accelerating_s());
            from.abs() + self.acc_lim_track * left_s
        }
    }

    /// Sets speeds within the deadband to zero.
    ///
    /// Speeds are not raised to the deadband, as motor drivers do for voltages: the base would move faster than commanded, and
    /// on noise alone. The planner reads the resulting standstill from the encoder.
    #[doc(hidden)]
    #[must_use]
    pub fn apply_deadband(&self, speeds: &TrackSpeeds) -> TrackSpeeds {
        speeds.map(|speed| if speed.abs() < self.deadband { 0.0 } else { speed })
    }

    /// The longest time to standstill, seconds.
    #[must_use]
    pub fn max_stopping_time_s(&self) -> f64 {
        self.max_track_speed / -self.decel_lim_track
    }
}

/// Converts twists to feasible track speeds. It keeps the last commanded speeds for its ramp.
#[derive(Clone, Debug)]
pub struct Mixer {
    drive: TrackedDrive,
    limits: TrackLimits,
    /// Current speeds of the ramp, before the deadband. A ramp that restarted from zero in each tick would never leave it.
    ramp: TrackSpeeds,
}

impl Mixer {
    /// Creates a mixer for standing tracks. The drive's width is the effective one; the limits are valid.
    #[must_use]
    pub fn new(drive: TrackedDrive, limits: TrackLimits) -> Self {
        Self { drive, limits, ramp: TrackSpeeds::default() }
    }

    /// Computes the track speeds to command, a time after the last call, seconds, or at a tick of a control loop. The target is
    /// mixed (eqs. 1 and 2), scaled to the largest track speed with constant curvature, ramped, and zeroed within the deadband.
    ///
    /// A target that is not finite counts as a stop.
    pub fn mix(&mut self, target: &Twist, elapsed: impl Into<TickTime>) -> TrackSpeeds {
        let target = if target.is_finite() { *target } else { Twist::STOP };
        let target = self.limits.scale_to_max(&self.drive.tracks(&target));
        self.ramp = self.limits.reachable(&self.ramp, &target, elapsed);
        self.limits.apply_deadband(&self.ramp)
    }

    /// The twist of track speeds at the effective width without slip, for bases that mix internally.
    #[must_use]
    pub fn twist(&self, tracks: &TrackSpeeds) -> Twist {
        self.drive.twist(tracks)
    }

    /// Restarts the ramp from measured track speeds, after a gap. A track that moves against its target, or not at all, restarts
    /// from standstill; none restarts beyond its target.
    pub fn restart(&mut self, measured: &TrackSpeeds, target: &Twist) {
        let target = if target.is_finite() { *target } else { Twist::STOP };
        let target = self.limits.scale_to_max(&self.drive.tracks(&target));
        self.ramp = measured.zip(target, |measured, target| {
            if measured * target > 0.0 {
                measured.abs().min(target.abs()).copysign(target)
            } else {
                0.0
            }
        });
    }

    /// Lowers the ramp of each track to at most its measured speed plus an allowance for its lag, m/s. A stop then brakes from
    /// where the track is, and not from a command that it has not followed.
    pub fn limit_to(&mut self, measured: &TrackSpeeds, allowance: f64) {
        self.ramp = self.ramp.zip(*measured, |ramp, measured| {
            let max = measured.abs() + allowance;
            if measured.is_finite() { ramp.clamp(-max, max) } else { ramp }
        });
    }

    /// Restarts the ramp from standstill, after an emergency stop or a lost connection.
    pub fn reset(&mut self) {
        self.ramp = TrackSpeeds::default();
    }
}
