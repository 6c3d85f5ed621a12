//! The ground under the tracks: how the speeds of the belts become motion.

use rand_pcg::Pcg64Mcg;

use super::Slip;
use super::rng::{RngStream, generator, standard_normal};
use crate::geometry::Twist;
use crate::robot::{TrackSpeeds, TrackedDrive};

/// However much slip wanders, the ground takes no more than this share of a belt's speed.
const MOST_SLIP: f64 = 0.95;

/// However much the effective width wanders, it is at least this share of its mean.
const LEAST_WIDTH: f64 = 0.5;

impl Slip {
    /// The drive that the controller of the base believes in.
    pub(super) fn believed(&self, drive: &TrackedDrive) -> TrackedDrive {
        TrackedDrive {
            track_width_m: drive.track_width_m * self.calibrated_width_ratio,
        }
    }
}

/// The ground of one run, as it is where the base stands.
#[derive(Clone, Debug)]
pub(super) struct Ground {
    slip: Slip,
    rng: Pcg64Mcg,
    /// Where slip and effective width stand in their wandering: an Ornstein-Uhlenbeck process over the way driven, of
    /// mean zero and deviation one.
    slip_wander: f64,
    width_wander: f64,
}

impl Ground {
    pub(super) fn new(slip: Slip, seed: u64) -> Self {
        let mut rng = generator(seed, RngStream::Ground);
        let (slip_wander, width_wander) = (standard_normal(&mut rng), standard_normal(&mut rng));
        Self {
            slip,
            rng,
            slip_wander,
            width_wander,
        }
    }

    /// How a base of this geometry moves when its belts run so.
    pub(super) fn twist(&self, drive: &TrackedDrive, tracks: &TrackSpeeds) -> Twist {
        let Slip {
            mean,
            width_ratio,
            variation,
            ..
        } = self.slip;
        let slip = (mean + variation * self.slip_wander).min(MOST_SLIP);
        let width = width_ratio * (1.0 + variation * self.width_wander).max(LEAST_WIDTH);
        let effective = TrackedDrive {
            track_width_m: drive.track_width_m * width,
        };
        effective.twist(&TrackSpeeds {
            left: tracks.left * (1.0 - slip),
            right: tracks.right * (1.0 - slip),
        })
    }

    /// Lets the belts run a distance, metres, the mean of both either way.
    pub(super) fn roll(&mut self, distance_m: f64) {
        if self.slip.variation > 0.0 && distance_m > 0.0 {
            let kept = libm::exp(-distance_m / self.slip.variation_length_m);
            let fresh = (1.0 - kept * kept).sqrt();
            for wander in [&mut self.slip_wander, &mut self.width_wander] {
                *wander = kept * *wander + fresh * standard_normal(&mut self.rng);
            }
        }
    }
}
