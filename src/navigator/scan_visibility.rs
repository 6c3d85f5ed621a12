//! Whether a lidar scan saw through a place.

use core::f64::consts::TAU;

use crate::geometry::{Point, Pose, bearing};
use crate::map::Scan;

/// A scan with the pose from which it was made.
#[derive(Clone, Debug, Default)]
pub(super) struct StampedScan {
    pub pose: Pose,
    pub scan: Scan,
}

impl StampedScan {
    /// Copies another scan into the memory of this one.
    pub fn copy(&mut self, pose: &Pose, scan: &Scan) {
        self.pose = *pose;
        self.scan.angle_min = scan.angle_min;
        self.scan.angle_increment = scan.angle_increment;
        self.scan.range_max = scan.range_max;
        self.scan.ranges.clone_from(&scan.ranges);
    }
}

/// Largest error of a pose, radians and metres: three standard deviations of each of two poses.
const YAW_ERROR: f64 = 0.012;
const PLACE_ERROR_M: f64 = 0.03;
/// Error of a distance as a share of it: beams meet far surfaces at a flatter angle.
const MARGIN_SHARE: f64 = 0.01;

/// The shortest range of the beams within an angle of a direction in the map frame, metres, and of the two next to it at least.
/// A beam without a return saw to the sensor's range. Nothing where a beam has no measurement or there is no beam.
pub(super) fn seen_to_m(pose: &Pose, scan: &Scan, direction: f64, half_angle: f64) -> Option<f64> {
    let beams = scan.ranges.len() as i64;
    if beams == 0 {
        return None;
    }
    let increment = scan.angle_increment;
    let turned = (direction - pose.yaw - scan.angle_min) / TAU;
    let turned = (turned - turned.floor()) * TAU;
    let half_angle = half_angle.max(increment);
    let from = ((turned - half_angle) / increment).ceil() as i64;
    let to = ((turned + half_angle) / increment).floor() as i64;
    let is_full_turn = is_full_turn(scan);
    if !is_full_turn && (from < 0 || to >= beams) {
        return None;
    }
    let mut least = scan.range_max;
    for beam in from..=to {
        let range = scan.ranges[beam.rem_euclid(beams) as usize];
        if range.is_nan() {
            return None;
        }
        least = least.min(range);
    }
    Some(least)
}

/// Whether the first beam follows the last.
pub(super) fn is_full_turn(scan: &Scan) -> bool {
    scan.ranges.len() as f64 * scan.angle_increment > TAU - 0.5 * scan.angle_increment
}

/// Whether the beams of a scan around a point all went beyond it by a margin, metres, for every pose within the error: then the
/// point was free.
///
/// The ranges of two neighbouring beams to a wall at a flat angle differ much. The beams on both sides count, so that a small
/// rotation of the robot does not let the scan see through the wall.
pub(super) fn proves_free(pose: &Pose, scan: &Scan, point: &Point, margin_m: f64) -> bool {
    let robot = pose.position();
    let distance = (point - robot).norm();
    let half_angle = YAW_ERROR + PLACE_ERROR_M / distance.max(PLACE_ERROR_M);
    let margin_m = margin_m + MARGIN_SHARE * distance;
    seen_to_m(pose, scan, bearing(&robot, point), half_angle)
        .is_some_and(|seen| seen > distance + margin_m)
}
