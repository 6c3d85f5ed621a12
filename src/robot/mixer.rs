//! Conversion of commanded twists to limited and ramped track speeds.

use super::{TrackLimits, TrackSpeeds, TrackedDrive};
use crate::geometry::Twist;

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

    /// Computes the track speeds to command, `elapsed_s` seconds after the last call. The target is mixed (eqs. 1 and 2), scaled
    /// to the largest track speed with constant curvature, ramped, and zeroed within the deadband.
    ///
    /// A target that is not finite counts as a stop.
    pub fn mix(&mut self, target: &Twist, elapsed_s: f64) -> TrackSpeeds {
        let target = if target.is_finite() { *target } else { Twist::STOP };
        let target = self.limits.scale_to_max(&self.drive.tracks(&target));
        self.ramp = self.limits.reachable(&self.ramp, &target, elapsed_s.max(0.0));
        self.limits.apply_deadband(&self.ramp)
    }

    /// The twist of track speeds at the effective width without slip, for bases that mix internally.
    #[must_use]
    pub fn twist(&self, tracks: &TrackSpeeds) -> Twist {
        self.drive.twist(tracks)
    }

    /// Restarts the ramp from standstill, after an emergency stop or a lost connection.
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
    fn ramp_of_small_steps_leaves_the_deadband() {
        let mut mixer = mixer();
        let commanded: Vec<f64> =
            (0..10).map(|_| mixer.mix(&Twist::new(0.5, 0.0), 0.01).left).collect();
        assert_eq!(commanded[3], 0.0, "0.04 m/s is within the deadband");
        assert!((commanded[9] - 0.1).abs() < 1e-12, "{commanded:?}");
    }

    #[test]
    fn target_that_is_not_finite_brakes() {
        let mut mixer = mixer();
        mixer.mix(&Twist::new(0.5, 0.0), 1.0);
        let commanded = mixer.mix(&Twist::new(f64::NAN, 0.2), 0.1);
        assert!((commanded.left - 0.4).abs() < 1e-12 && (commanded.right - 0.4).abs() < 1e-12);
        mixer.reset();
        assert_eq!(mixer.mix(&Twist::STOP, 0.0), TrackSpeeds::default());
    }
}
