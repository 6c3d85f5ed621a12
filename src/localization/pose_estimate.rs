//! What a localiser says of the pose.

use core::fmt;

use nalgebra::Matrix3;
use serde::Serialize;

use super::Agreement;
use crate::geometry::Pose;

/// Why a robot does not know where it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LostReason {
    /// The lidar measures nothing where the map has walls.
    NoReturns,
    /// Too many beams pass through walls of the map.
    BeamsThroughWalls,
    /// Too few beams end on walls of the map.
    PoorMatch,
    /// The map would have it where the robot cannot have driven.
    PoseJump,
    /// Nothing to hold on to for so long that odometry alone does not tell where it is.
    HighUncertainty,
}

impl fmt::Display for LostReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NoReturns => "the lidar measures nothing where the map has walls",
            Self::BeamsThroughWalls => "the lidar sees through walls of the map",
            Self::PoorMatch => "what the lidar sees is not on the map",
            Self::PoseJump => "the map fits best where the robot cannot have driven",
            Self::HighUncertainty => "walls have told too little of the place for too long",
        })
    }
}

/// How much a pose is worth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LocalizationStatus {
    /// The scans agree with the map at this pose.
    Tracking,
    /// They did until a moment ago, or have not told enough yet.
    Uncertain,
    /// The robot does not know where it is.
    Lost(LostReason),
}

impl LocalizationStatus {
    /// Why, of a robot that is lost.
    #[must_use]
    pub const fn lost_reason(&self) -> Option<LostReason> {
        match self {
            Self::Lost(why) => Some(*why),
            Self::Tracking | Self::Uncertain => None,
        }
    }
}

/// The pose after a revolution, and what speaks for it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseEstimate {
    /// The moment of the pose, seconds: that of the newest odometry.
    pub time_s: f64,
    /// Where the robot is, in the map frame.
    pub pose: Pose,
    /// How well that is known: covariance of x, y and yaw in the map frame, square metres and radians.
    pub covariance: Matrix3<f64>,
    /// How the beams agree with the map at this pose.
    pub agreement: Agreement,
    /// Root mean square distance from the walls of the beams that count, metres, weighted as they count; zero where none does.
    pub rms_m: f64,
    /// Directions of motion, of three, that the walls told nothing of.
    pub unobservable_directions: u8,
    /// Rounds of the matching.
    pub iterations: u8,
    /// How much it is worth.
    pub status: LocalizationStatus,
}

impl PoseEstimate {
    /// Standard deviation of the position along the axis where it is largest, any axis, metres.
    #[must_use]
    pub fn sigma_m(&self) -> f64 {
        let (a, b, c) = (
            self.covariance[(0, 0)],
            self.covariance[(0, 1)],
            self.covariance[(1, 1)],
        );
        let (mean, half) = (f64::midpoint(a, c), (a - c) / 2.0);
        (mean + (half * half + b * b).sqrt()).max(0.0).sqrt()
    }

    /// Standard deviation of the yaw, radians.
    #[must_use]
    pub fn sigma_rad(&self) -> f64 {
        self.covariance[(2, 2)].max(0.0).sqrt()
    }
}
