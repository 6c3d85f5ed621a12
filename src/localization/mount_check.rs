//! The direction of motion by matched scans against that by odometry: a lidar that is turned on the robot shows another one.

use crate::geometry::{Pose, bearing, wrap_angle};

/// A straight piece of the way is at least this long, metres, and turns by at most this, radians.
const PIECE_M: f64 = 0.3;
const STRAIGHT_RAD: f64 = 0.1;
/// The direction is judged after this many metres of such pieces. The latest ones of this length count most.
const JUDGED_M: f64 = 3.0;
/// A lidar is turned from this angle on, radians. Tracks drift sideways by less, also across a slope.
const TURNED_RAD: f64 = 0.12;

/// Compares matched poses with odometry.
#[derive(Clone, Debug, Default)]
pub(super) struct MountCheck {
    /// Poses by odometry and by the map where the piece began.
    begin: Option<(Pose, Pose)>,
    /// Sums over the pieces, by their length, metres: of sine and cosine of the angle, and of one.
    sin_m: f64,
    cos_m: f64,
    judged_m: f64,
}

impl MountCheck {
    /// Adds a matched pose. Returns whether the lidar is turned on the robot against its mounting.
    pub fn is_turned(&mut self, odometry: &Pose, matched: &Pose) -> bool {
        let (by_odometry, by_map) = *self.begin.get_or_insert((*odometry, *matched));
        let moved_m = |from: &Pose, to: &Pose| (to.position() - from.position()).norm();
        let turned_rad = wrap_angle(odometry.yaw - by_odometry.yaw).abs();
        let length_m = moved_m(&by_odometry, odometry);
        if turned_rad > STRAIGHT_RAD {
            self.begin = None;
        } else if length_m >= PIECE_M && moved_m(&by_map, matched) >= 0.5 * PIECE_M {
            let direction =
                |from: &Pose, to: &Pose| bearing(&from.position(), &to.position()) - from.yaw;
            let (sin, cos) =
                libm::sincos(direction(&by_map, matched) - direction(&by_odometry, odometry));
            let kept = (1.0 - length_m / JUDGED_M).max(0.0);
            let kept = if self.judged_m < JUDGED_M { 1.0 } else { kept };
            self.sin_m = kept * self.sin_m + length_m * sin;
            self.cos_m = kept * self.cos_m + length_m * cos;
            self.judged_m += length_m;
            self.begin = None;
        }
        self.judged_m >= JUDGED_M && libm::atan2(self.sin_m, self.cos_m).abs() >= TURNED_RAD
    }

    /// The check on another map, to whose grid a function converts poses.
    pub fn on(&self, converted: impl Fn(&Pose) -> Pose) -> Self {
        let begin = self.begin.map(|(odometry, matched)| (odometry, converted(&matched)));
        Self { begin, ..self.clone() }
    }

    /// Begins another piece: the robot was found at another place.
    pub fn begin_again(&mut self) {
        self.begin = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The metres after which a drive in a direction shows a lidar that is turned by an angle; none within 8 m. The robot slips
    /// sideways by a share of its way.
    fn turned_after_m(yaw: f64, turned: f64, drift: f64, curvature: f64) -> Option<f64> {
        let mut check = MountCheck::default();
        let mut truth = Pose::new(3.0, -2.0, yaw);
        let mut odometry = Pose::new(7.0, 1.0, -1.0);
        (0..160).map(|step| 0.05 * f64::from(step)).find(|_| {
            truth = truth.transform_pose(&Pose::new(0.05, 0.05 * drift, 0.05 * curvature));
            odometry = odometry.transform_pose(&Pose::new(0.05, 0.0, 0.05 * curvature));
            check.is_turned(&odometry, &Pose { yaw: wrap_angle(truth.yaw - turned), ..truth })
        })
    }

    #[test]
    fn lidar_that_is_turned_shows_after_three_metres() {
        for yaw in [0.0, 1.0, 3.1] {
            for turned in [0.17, -0.17, 1.57, 3.1] {
                let after_m = turned_after_m(yaw, turned, 0.0, 0.0);
                assert!(after_m.is_some_and(|m| (2.9..3.6).contains(&m)), "{turned}: {after_m:?}");
            }
            assert_eq!(turned_after_m(yaw, 0.05, 0.0, 0.0), None);
            assert_eq!(turned_after_m(yaw, 0.0, 0.08, 0.0), None, "drift on a slope");
            assert_eq!(turned_after_m(yaw, 0.17, 0.0, 1.0), None, "no straight piece");
        }
    }
}
