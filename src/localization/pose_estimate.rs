//! The result of localisation: pose, covariance and status.

use serde::Serialize;

use super::{Agreement, LocalizationSettings};
use crate::geometry::Pose;
use crate::settings::words;

words! {
    /// Why localisation is lost.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, thiserror::Error)]
    #[non_exhaustive]
    pub enum LostReason {
        /// The lidar has too few returns where the map shows surfaces.
        #[error("the lidar has no returns where the map shows walls")]
        NoReturns = "no_returns",
        /// Too many beams pass through mapped obstacles.
        #[error("lidar beams pass through walls of the map")]
        BeamsThroughWalls = "beams_through_walls",
        /// Too few beams end on mapped surfaces.
        #[error("the scan does not match the map")]
        PoorMatch = "poor_match",
        /// The best match is farther away than the robot can have driven.
        #[error("the best match is farther away than the robot can have driven")]
        PoseJump = "pose_jump",
        /// The covariance has grown too large without corrections.
        #[error("the scans have not constrained the pose for too long")]
        HighUncertainty = "high_uncertainty",
        /// Several places of the map match the scan about as well.
        #[error("several places of the map match the scan")]
        Ambiguous = "ambiguous",
        /// Odometry moves, and the scans stay the same.
        #[error("the robot does not move although its tracks do, or its lidar is frozen")]
        NotMoving = "not_moving",
        /// The pose was found and lost again at the same place several times.
        #[error(
            "the pose is found and lost again and again at the same place: check the mounting of the lidar, and the scale of the odometry"
        )]
        LostAgain = "lost_again",
        /// Another place of the map matches much better.
        #[error("another place of the map matches the scan much better")]
        BetterElsewhere = "better_elsewhere",
        /// No pose was given at the start, or the scans have not confirmed the given one yet.
        #[error("no pose was given at the start, or the scans have not confirmed it yet")]
        NoPose = "no_pose",
        /// The robot moves farther than its odometry says, by more than slip or a worn track explain.
        #[error(
            "it moves more than 1.3 times as far as its odometry says: calibrate the base (`inbye base calibrate` finds ticks_per_m), or \
             correct the scale of the odometry"
        )]
        OdometryScale = "odometry_scale",
        /// The robot moves in another direction than its scans show.
        #[error(
            "it moves in another direction than its scans show: correct the yaw of the lidar's mounting on the robot"
        )]
        LidarTurned = "lidar_turned",
    }
}

/// Reliability of the pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum LocalizationStatus {
    /// The scans match the map at this pose.
    Tracking,
    /// Recent scans do not match, or the covariance is still large.
    Uncertain,
    /// The pose is unknown.
    Lost(LostReason),
}

impl LocalizationStatus {
    /// The reason, if localisation is lost.
    #[must_use]
    pub const fn lost_reason(&self) -> Option<LostReason> {
        match self {
            Self::Lost(reason) => Some(*reason),
            Self::Tracking | Self::Uncertain => None,
        }
    }
}

/// The pose estimate after a revolution, with its quality.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct PoseEstimate {
    /// Time of the pose, seconds: that of the latest odometry.
    pub time_s: f64,
    /// The pose in the map frame.
    pub pose: Pose,
    /// Covariance of x, y and yaw in the map frame, square metres and radians.
    pub covariance: [[f64; 3]; 3],
    /// Consistency of the beams with the map at this pose.
    pub agreement: Agreement,
    /// Weighted root mean square distance of the matched beam ends from the mapped surfaces, metres; zero without matches.
    pub rms_m: f64,
    /// Number of unobservable directions of motion, of three.
    pub unobservable_directions: u8,
    /// Iterations of the scan matcher.
    pub iterations: u8,
    /// Reliability of the pose.
    pub status: LocalizationStatus,
}

impl PoseEstimate {
    /// Largest standard deviation of the position along any axis, metres.
    #[must_use]
    pub fn sigma_m(&self) -> f64 {
        self.sigmas_m()[0]
    }

    /// Largest and smallest standard deviation of the position along any axis, metres.
    pub(super) fn sigmas_m(&self) -> [f64; 2] {
        let [[a, b, _], [_, c, _], _] = self.covariance;
        axis_variances(a, b, c).map(sigma)
    }

    /// Whether too little is known of the pose. Along a smooth roadway the scans show where the walls are, which is enough to drive.
    pub(super) fn is_unknown(&self, settings: &LocalizationSettings) -> bool {
        let [most_m, least_m] = self.sigmas_m();
        let limit_m = settings.lost_sigma_m;
        let is_along_walls = self.unobservable_directions == 1;
        let along_m = if is_along_walls { settings.lost_sigma_along_m } else { limit_m };
        most_m > along_m.max(limit_m)
            || least_m > limit_m
            || self.sigma_rad() > settings.lost_sigma_rad
    }

    /// Standard deviation of the yaw, radians.
    #[must_use]
    pub fn sigma_rad(&self) -> f64 {
        sigma(self.covariance[2][2])
    }
}

/// The largest and the smallest variance along any axis, of the covariance ((a, b), (b, c)).
pub(super) fn axis_variances(a: f64, b: f64, c: f64) -> [f64; 2] {
    let (mean, half) = (f64::midpoint(a, c), (a - c) / 2.0);
    let differs = (half * half + b * b).sqrt();
    [mean + differs, mean - differs]
}

/// The standard deviation of a variance. One that was computed from numbers without a limit is infinite: the pose is unknown.
fn sigma(variance: f64) -> f64 {
    if variance.is_nan() { f64::INFINITY } else { variance.max(0.0).sqrt() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unknown_variance_is_not_certain() {
        assert_eq!([f64::NAN, f64::INFINITY].map(sigma), [f64::INFINITY; 2]);
        assert!((sigma(0.04) - 0.2).abs() < 1e-12 && sigma(-1e-20) == 0.0);
    }
}
