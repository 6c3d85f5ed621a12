//! Track slip: converts belt speeds to the motion of the base.

use rand_pcg::Pcg64Mcg;

use super::Slip;
use super::rng::{RngStream, generator, standard_normal};
use crate::geometry::Twist;
use crate::robot::{TrackSpeeds, TrackedDrive};

/// Largest slip, as a fraction of the belt's speed.
const MAX_SLIP: f64 = 0.95;

/// Smallest effective width, as a fraction of its mean.
const MIN_WIDTH: f64 = 0.5;

impl Slip {
    /// The drive with the controller's calibrated width.
    pub(super) fn calibrated(&self, drive: &TrackedDrive) -> TrackedDrive {
        TrackedDrive { track_width_m: drive.track_width_m * self.calibrated_width_ratio }
    }
}

/// The ground of one run at the position of the base.
#[derive(Clone, Debug)]
pub(super) struct Ground {
    slip: Slip,
    rng: Pcg64Mcg,
    /// States of the variation of slip and effective width: Ornstein-Uhlenbeck processes over the distance driven, with
    /// mean zero and deviation one.
    slip_state: f64,
    width_state: f64,
}

impl Ground {
    pub(super) fn new(slip: Slip, seed: u64) -> Self {
        let mut rng = generator(seed, RngStream::Ground);
        let (slip_state, width_state) = (standard_normal(&mut rng), standard_normal(&mut rng));
        Self { slip, rng, slip_state, width_state }
    }

    /// Returns the true motion of a base with these belt speeds.
    pub(super) fn twist(&self, drive: &TrackedDrive, tracks: &TrackSpeeds) -> Twist {
        let Slip { mean, width_ratio, variation, .. } = self.slip;
        let slip = (mean + variation * self.slip_state).min(MAX_SLIP);
        let width = width_ratio * (1.0 + variation * self.width_state).max(MIN_WIDTH);
        let effective = TrackedDrive { track_width_m: drive.track_width_m * width };
        effective.twist(&TrackSpeeds {
            left: tracks.left * (1.0 - slip),
            right: tracks.right * (1.0 - slip),
        })
    }

    /// Advances the variation by a distance, metres: the mean of both belts' absolute travel.
    pub(super) fn roll(&mut self, distance_m: f64) {
        if self.slip.variation > 0.0 && distance_m > 0.0 {
            let kept = libm::exp(-distance_m / self.slip.variation_length_m);
            let fresh = (1.0 - kept * kept).sqrt();
            for state in [&mut self.slip_state, &mut self.width_state] {
                *state = kept * *state + fresh * standard_normal(&mut self.rng);
            }
        }
    }
}
