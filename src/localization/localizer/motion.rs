//! The motion by matched scans against that by odometry.

use super::{Localizer, SAME_PLACE_AGREEMENT, has_moved};
use crate::geometry::Pose;
use crate::localization::LostReason;
use crate::localization::scan_matcher::information_of;

/// Motion by odometry since the last accepted revolution, metres and radians. A scan that still matches there, within the
/// second value, then shows a robot that does not move.
pub(super) const MOVED_M: f64 = 0.18;
pub(super) const MOVED_RAD: f64 = 0.18;
const SAME_M: f64 = 0.1;
const SAME_RAD: f64 = 0.08;
/// By how much more the scan agrees there than at the predicted pose.
const NOT_PREDICTED: f64 = 0.05;
/// Standard deviations of that pose, metres and radians.
const SAME_SIGMA_M: f64 = 0.03;
const SAME_SIGMA_RAD: f64 = 0.03;

/// A robot that slips moves less than its tracks. One that moves more than this times as far as its odometry has a wrong scale: it would
/// drive faster than its limits.
const MAX_DISTANCE_SCALE: f64 = 1.3;

impl Localizer {
    /// Whether the scan still matches where the last accepted one did, although odometry has moved since.
    pub(super) fn is_at_anchor(&self, predicted: &Pose) -> bool {
        let Some(anchor) = &self.anchor else {
            return false;
        };
        if !has_moved(&anchor.odometry, &self.odometry(), MOVED_M, MOVED_RAD) {
            return false;
        }
        let information = information_of(SAME_SIGMA_M, SAME_SIGMA_RAD);
        let matched = self.matcher().match_scan(&anchor.matched, &information, SAME_SIGMA_M);
        let share = |pose: &Pose| self.matcher().agreement(pose).matching_fraction();
        let agreement = share(&matched.pose);
        matched.unobservable_directions == 0
            && !has_moved(&anchor.matched, &matched.pose, SAME_M, SAME_RAD)
            && agreement >= self.settings.min_agreement.max(SAME_PLACE_AGREEMENT * anchor.agreement)
            // Among walls that have changed, the robot may be rejected where it is predicted.
            && agreement >= share(predicted) + NOT_PREDICTED
    }

    /// Loses a robot that does not move although its odometry does. It stands where it was matched last.
    pub(super) fn lose_without_motion(&mut self) {
        if let Some(anchor) = self.anchor {
            self.ekf = self.ekf.reset_pose(anchor.matched, &self.settings);
        }
        self.lose(LostReason::NotMoving);
    }

    /// What the motion shows to be wrong in the settings of odometry or lidar, with a new matched pose. A log is no drive.
    pub(super) fn wrong_setup(&mut self, odometry: &Pose, matched: &Pose) -> Option<LostReason> {
        if self.has_sparse_scans {
            return None;
        }
        if self.motion_check.mount.is_turned(odometry, matched) {
            return Some(LostReason::LidarTurned);
        }
        (self.ekf.odometry_scale().0 > MAX_DISTANCE_SCALE).then_some(LostReason::OdometryScale)
    }
}
