//! The ground under the tracks: how the speeds of the belts become motion.

use rand_pcg::Pcg64Mcg;
use serde::{Deserialize, Serialize};

use super::SimError;
use super::error::{above_zero, require};
use super::rng::{RngStream, generator, standard_normal};
use crate::documented::documented;
use crate::geometry::Twist;
use crate::robot::{TrackSpeeds, TrackedDrive};

/// However much slip wanders, the ground takes no more than this share of a belt's speed.
const MOST_SLIP: f64 = 0.95;

/// However much the effective width wanders, it is at least this share of its mean.
const LEAST_WIDTH: f64 = 0.5;

documented! {
    /// How tracks slip.
    ///
    /// A tracked base turns by dragging its tracks sideways. On given ground and at moderate speed each track then turns
    /// about a point that lies outside it and stays nearly where it is, so that the base moves like one of ideal wheels set
    /// farther apart (Martínez, Mandow et al., "Approximating Kinematics for Tracked Mobile Robots", International Journal of
    /// Robotics Research 24 (10), 2005; Mandow et al., "Experimental kinematics for wheeled skid-steer mobile robots", IROS
    /// 2007). The ratio of this effective width to the geometric one is what ROS calls the wheel separation multiplier.
    /// Sideways slip of the whole base is not simulated.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct Slip {
        /// Share of each belt's speed that is lost on the ground, at least zero and below one; on straights and in turns.
        /// Default 0.025: our own choice for firm ground; on sand and slopes it is many times more.
        pub mean: f64,
        /// Effective track width over the geometric one, above zero: 1 for ideal wheels, more for tracks. Default 1.5: our
        /// own choice between 1 and the 1.875 that the maker of the skid-steered Husky configures for it.
        pub width_ratio: f64,
        /// The same as the controller of the base believes it, above zero: it turns a command into belt speeds with it.
        /// Default 1.455, 3 % too little: our own choice. What is calibrated on one floor is off by more on another.
        pub calibrated_width_ratio: f64,
        /// Standard deviation of the slow change of both, 0 to 0.2: of the slip in shares of the belt's speed, of the
        /// effective width in shares of itself. Default 0.02: our own choice, such that with the scale errors of the
        /// odometry dead reckoning is off by some percent of the way, as tracked robots are in the field: with calibrated
        /// centres of rotation 1 % is reached (0.42 m of 40.5 m: Pentzer, Brennan and Reichard, Journal of Field Robotics,
        /// 2014).
        pub wander: f64,
        /// Way driven, metres, above zero, after which that change has forgotten all but 1/e of itself. Default 2 m, a few
        /// lengths of the base: our own choice for patches of different ground.
        pub wander_length_m: f64,
    }
}

impl Default for Slip {
    fn default() -> Self {
        Self {
            mean: 0.025,
            width_ratio: 1.5,
            calibrated_width_ratio: 1.455,
            wander: 0.02,
            wander_length_m: 2.0,
        }
    }
}

impl Slip {
    /// Ground that takes belt speeds as the equations without slip do.
    #[must_use]
    pub const fn none() -> Self {
        Self {
            mean: 0.0,
            width_ratio: 1.0,
            calibrated_width_ratio: 1.0,
            wander: 0.0,
            wander_length_m: 1.0,
        }
    }

    /// Checks every number.
    ///
    /// # Errors
    /// [`SimError::BadSetting`] names the first that is out of range.
    pub fn validate(&self) -> Result<(), SimError> {
        require(
            self.mean >= 0.0 && self.mean < 1.0,
            "slip.mean",
            self.mean,
            "at least zero and below one",
        )?;
        above_zero("slip.width_ratio", self.width_ratio)?;
        above_zero("slip.calibrated_width_ratio", self.calibrated_width_ratio)?;
        require(
            (0.0..=0.2).contains(&self.wander),
            "slip.wander",
            self.wander,
            "0 to 0.2",
        )?;
        above_zero("slip.wander_length_m", self.wander_length_m)
    }

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
            wander,
            ..
        } = self.slip;
        let slip = (mean + wander * self.slip_wander).min(MOST_SLIP);
        let width = width_ratio * (1.0 + wander * self.width_wander).max(LEAST_WIDTH);
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
        if self.slip.wander > 0.0 && distance_m > 0.0 {
            let kept = libm::exp(-distance_m / self.slip.wander_length_m);
            let fresh = (1.0 - kept * kept).sqrt();
            for wander in [&mut self.slip_wander, &mut self.width_wander] {
                *wander = kept * *wander + fresh * standard_normal(&mut self.rng);
            }
        }
    }
}
