//! From a wanted motion to the speeds of two tracks, tick after tick.

use super::{TrackLimits, TrackSpeeds, TrackedDrive};
use crate::geometry::Twist;

/// Turns wanted motions into what the tracks can do, and remembers how fast they were told to run.
#[derive(Clone, Debug)]
pub struct Mixer {
    drive: TrackedDrive,
    limits: TrackLimits,
    /// Where the ramp stands. Without the deadband: a ramp that began anew from zero at each tick never left it.
    ramp: TrackSpeeds,
}

impl Mixer {
    /// A mixer for tracks that stand. The drive's width is the effective one; the limits are valid.
    #[must_use]
    pub fn new(drive: TrackedDrive, limits: TrackLimits) -> Self {
        Self {
            drive,
            limits,
            ramp: TrackSpeeds::default(),
        }
    }

    /// The motion to tell the base, a time in seconds after the last: mixed (eqs. 1 and 2), scaled to the highest speed
    /// of a track with the curvature kept, ramped, and without what no track can do so slowly.
    ///
    /// A motion that is not finite counts as a stop.
    pub fn mix(&mut self, wanted: &Twist, elapsed_s: f64) -> TrackSpeeds {
        let wanted = if wanted.is_finite() {
            *wanted
        } else {
            Twist::STOP
        };
        let target = self.limits.within(&self.drive.tracks(&wanted));
        self.ramp = self
            .limits
            .reachable(&self.ramp, &target, elapsed_s.max(0.0));
        self.limits.without_deadband(&self.ramp)
    }

    /// The motion that those track speeds are without slip at the effective width: for bases that mix themselves.
    #[must_use]
    pub fn twist(&self, tracks: &TrackSpeeds) -> Twist {
        self.drive.twist(tracks)
    }

    /// Begins anew from a standstill: after an emergency stop or a lost line.
    pub fn reset(&mut self) {
        self.ramp = TrackSpeeds::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mixer() -> Mixer {
        let limits = TrackLimits {
            max_track_speed: 1.0,
            acc_lim_track: 1.0,
            decel_lim_track: -1.0,
            deadband: 0.05,
        };
        Mixer::new(TrackedDrive { track_width_m: 0.5 }, limits)
    }

    #[test]
    fn a_ramp_of_small_steps_leaves_the_deadband() {
        let mut mixer = mixer();
        let told: Vec<f64> = (0..10)
            .map(|_| mixer.mix(&Twist::new(0.5, 0.0), 0.01).left)
            .collect();
        assert_eq!(told[3], 0.0, "0.04 m/s is within the deadband");
        assert!((told[9] - 0.1).abs() < 1e-12, "{told:?}");
    }

    #[test]
    fn what_is_not_finite_brakes() {
        let mut mixer = mixer();
        mixer.mix(&Twist::new(0.5, 0.0), 1.0);
        let told = mixer.mix(&Twist::new(f64::NAN, 0.2), 0.1);
        assert!((told.left - 0.4).abs() < 1e-12 && (told.right - 0.4).abs() < 1e-12);
        mixer.reset();
        assert_eq!(mixer.mix(&Twist::STOP, 0.0), TrackSpeeds::default());
    }
}
