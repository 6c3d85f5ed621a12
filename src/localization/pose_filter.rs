//! Pose of the robot in the map frame, from drifting odometry and absolute pose measurements.
//!
//! Odometry is smooth and drifts; a measurement, by a scan matcher or a total station, is noisy and does not drift. An extended
//! Kalman filter (Thrun, Burgard and Fox, "Probabilistic Robotics", 2005, section 3.3) fuses both. Its input is in REP-105's
//! odom frame, its output in the map frame.

use nalgebra::{Matrix3, Vector3};

use crate::geometry::{Pose, wrap_angle};

/// A measured pose in the map frame with its accuracy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseMeasurement {
    /// The pose, metres and radians.
    pub pose: Pose,
    /// Standard deviation along each axis, metres, above zero.
    pub sigma_m: f64,
    /// Standard deviation of the yaw, radians, above zero.
    pub sigma_rad: f64,
}

/// Variance along the motion, m^2 per metre driven: 3 cm after one metre, the slip of tracks (our choice).
const ALONG_M2_PER_M: f64 = 9e-4;
/// Variance across the motion, m^2 per metre driven, and per radian turned in place (our choice).
const ACROSS_M2_PER_M: f64 = 2e-4;
const ACROSS_M2_PER_RAD: f64 = 1e-4;
/// Variance of the yaw, rad^2 per metre driven and per radian turned: a gyro's scale error (our choice).
const YAW_RAD2_PER_M: f64 = 1e-5;
const YAW_RAD2_PER_RAD: f64 = 4e-4;
/// Variance that each reading adds even at rest, m^2 and rad^2, so that no measurement ever loses all weight.
const AT_REST_M2: f64 = 1e-8;
const AT_REST_RAD2: f64 = 1e-8;
/// A measurement further off than this many standard deviations is an outlier: one in ten thousand sound ones.
const GATE_SIGMAS: f64 = 4.6;
/// This many outliers in a row are accepted: the filter itself is wrong then.
const ACCEPTED_AFTER: u32 = 10;

/// An estimate of the robot's pose in the map frame.
#[derive(Clone, Debug)]
pub struct PoseFilter {
    pose: Pose,
    covariance: Matrix3<f64>,
    odometry: Option<Pose>,
    outliers: u32,
}

impl PoseFilter {
    /// A filter for a robot that stands at a measured pose.
    #[must_use]
    pub fn new(start: &PoseMeasurement) -> Self {
        Self { pose: start.pose, covariance: noise(start), odometry: None, outliers: 0 }
    }

    /// The estimate.
    #[must_use]
    pub const fn pose(&self) -> &Pose {
        &self.pose
    }

    /// Predicts with a pose in the odom frame. The first one only sets the frame; one that is not finite is ignored.
    pub fn predict(&mut self, odometry: &Pose) {
        if !odometry.is_finite() {
            return;
        }
        let Some(before) = self.odometry.replace(*odometry) else {
            return;
        };
        let step = before.inverse_transform(&odometry.position());
        let turn = wrap_angle(odometry.yaw - before.yaw);
        let (sin, cos) = libm::sincos(self.pose.yaw);
        let (dx, dy) = (cos * step.x - sin * step.y, sin * step.x + cos * step.y);
        self.pose = Pose {
            x: self.pose.x + dx,
            y: self.pose.y + dy,
            yaw: wrap_angle(self.pose.yaw + turn),
        };
        // An error of the yaw rotates the step.
        let transition = Matrix3::new(1.0, 0.0, -dy, 0.0, 1.0, dx, 0.0, 0.0, 1.0);
        let driven_m = step.coords.norm();
        let along = ALONG_M2_PER_M * driven_m + AT_REST_M2;
        let across = ACROSS_M2_PER_M * driven_m + ACROSS_M2_PER_RAD * turn.abs() + AT_REST_M2;
        let spread = (along - across) * cos * sin;
        let added = Matrix3::new(
            along * cos * cos + across * sin * sin,
            spread,
            0.0,
            spread,
            along * sin * sin + across * cos * cos,
            0.0,
            0.0,
            0.0,
            YAW_RAD2_PER_M * driven_m + YAW_RAD2_PER_RAD * turn.abs() + AT_REST_RAD2,
        );
        self.covariance = transition * self.covariance * transition.transpose() + added;
    }

    /// Corrects with a measured pose and returns whether it was accepted. It rejects one that is not finite, and an outlier
    /// unless many in a row were outliers.
    pub fn correct(&mut self, measured: &PoseMeasurement) -> bool {
        if !(measured.pose.is_finite() && measured.sigma_m > 0.0 && measured.sigma_rad > 0.0) {
            return false;
        }
        let off = Vector3::new(
            measured.pose.x - self.pose.x,
            measured.pose.y - self.pose.y,
            wrap_angle(measured.pose.yaw - self.pose.yaw),
        );
        let noise = noise(measured);
        let Some(information) = (self.covariance + noise).try_inverse() else {
            return false;
        };
        if (off.transpose() * information * off)[0] > GATE_SIGMAS * GATE_SIGMAS {
            self.outliers += 1;
            if self.outliers >= ACCEPTED_AFTER {
                *self = Self { odometry: self.odometry, ..Self::new(measured) };
                return true;
            }
            return false;
        }
        self.outliers = 0;
        let gain = self.covariance * information;
        let shift = gain * off;
        self.pose = Pose {
            x: self.pose.x + shift.x,
            y: self.pose.y + shift.y,
            yaw: wrap_angle(self.pose.yaw + shift.z),
        };
        // Joseph's form stays symmetric and positive definite in spite of rounding.
        let kept = Matrix3::identity() - gain;
        self.covariance =
            kept * self.covariance * kept.transpose() + gain * noise * gain.transpose();
        true
    }
}

fn noise(measured: &PoseMeasurement) -> Matrix3<f64> {
    let position = measured.sigma_m * measured.sigma_m;
    Matrix3::from_diagonal(&Vector3::new(
        position,
        position,
        measured.sigma_rad * measured.sigma_rad,
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::FRAC_PI_2;

    const START: PoseMeasurement =
        PoseMeasurement { pose: Pose::new(3.0, -2.0, FRAC_PI_2), sigma_m: 0.01, sigma_rad: 0.005 };

    /// A quarter circle to the left of radius 2 m, in its own frame.
    fn arc(step: u32) -> Pose {
        let angle = FRAC_PI_2 * f64::from(step) / 100.0;
        let (sin, cos) = libm::sincos(angle);
        Pose::new(2.0 * sin, 2.0 * (1.0 - cos), angle)
    }

    #[test]
    fn prediction_alone_is_odometry_from_the_start() {
        let mut filter = PoseFilter::new(&START);
        (0..=100).for_each(|step| filter.predict(&arc(step)));
        let pose = filter.pose();
        assert!((pose.x - 1.0).abs() < 1e-12 && pose.y.abs() < 1e-12, "{pose:?}");
        assert!((wrap_angle(pose.yaw).abs() - core::f64::consts::PI).abs() < 1e-12);
        let variance = filter.covariance[(0, 0)].max(filter.covariance[(1, 1)]);
        let sigma_m = variance.sqrt();
        assert!((0.02..0.08).contains(&sigma_m), "{sigma_m}");
    }

    #[test]
    fn corrections_remove_odometry_drift() {
        let mut filter = PoseFilter::new(&START);
        for step in 0..=100 {
            // Odometry that measures 5 % too much.
            let true_pose = arc(step);
            filter.predict(&Pose::new(1.05 * true_pose.x, 1.05 * true_pose.y, true_pose.yaw));
            let pose = START.pose.isometry() * true_pose.isometry();
            let measured = PoseMeasurement {
                pose: Pose::new(pose.translation.x, pose.translation.y, pose.rotation.angle()),
                ..START
            };
            assert!(filter.correct(&measured));
        }
        let pose = filter.pose();
        assert!((pose.x - 1.0).abs() < 5e-3 && pose.y.abs() < 5e-3, "{pose:?}");
    }

    #[test]
    fn outlier_is_rejected_until_ten_agree() {
        let mut filter = PoseFilter::new(&START);
        let outlier = PoseMeasurement { pose: Pose::new(4.0, -2.0, FRAC_PI_2), ..START };
        for _ in 1..ACCEPTED_AFTER {
            assert!(!filter.correct(&outlier));
            assert_eq!(*filter.pose(), START.pose);
        }
        assert!(filter.correct(&outlier));
        assert_eq!(*filter.pose(), outlier.pose);
        let nan = PoseMeasurement { pose: Pose::new(f64::NAN, 0.0, 0.0), ..START };
        assert!(!filter.correct(&nan));
        filter.predict(&Pose::new(f64::INFINITY, 0.0, 0.0));
        assert_eq!(*filter.pose(), outlier.pose);
    }
}
