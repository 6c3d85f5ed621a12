//! Where the robot is: drifting odometry, held to the map by fixes.
//!
//! Odometry is smooth and drifts; a fix, from a scan matcher or a total station say, is noisy and does not. An extended
//! Kalman filter (Thrun, Burgard and Fox, "Probabilistic Robotics", 2005, section 3.3) keeps the better of both: REP-105's
//! map frame is what it returns, the odom frame what it is fed.

use nalgebra::{Matrix3, Vector3};

use crate::geometry::{Pose, wrap_angle};

/// A pose in the map frame, measured, and how well.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseMeasurement {
    /// The pose, metres and radians.
    pub pose: Pose,
    /// Standard deviation along each axis, metres, above zero.
    pub sigma_m: f64,
    /// Standard deviation of the yaw, radians, above zero.
    pub sigma_rad: f64,
}

/// Variance of a way by odometry, m^2 for each metre: 3 cm after one metre, the slip of tracks (our choice).
const ALONG_M2_PER_M: f64 = 9e-4;
/// Variance to the side, m^2 for each metre driven, and for each radian turned on the spot (our choice).
const ASIDE_M2_PER_M: f64 = 2e-4;
const ASIDE_M2_PER_RAD: f64 = 1e-4;
/// Variance of the yaw, rad^2 for each metre driven and for each radian turned: a gyro's scale error (our choice).
const TURN_RAD2_PER_M: f64 = 1e-5;
const TURN_RAD2_PER_RAD: f64 = 4e-4;
/// What even a robot at rest forgets with each reading, m^2 and rad^2, so that no fix is ever of no account.
const AT_REST_M2: f64 = 1e-8;
const AT_REST_RAD2: f64 = 1e-8;
/// A fix further off than this many standard deviations is not believed: one in ten thousand sound ones.
const GATE_SIGMAS: f64 = 4.6;
/// So many in a row that are not believed are believed after all: it is the filter that has lost its way.
const BELIEVED_AFTER: u32 = 10;

/// An estimate of the robot's pose in the map frame.
#[derive(Clone, Debug)]
pub struct PoseFilter {
    pose: Pose,
    covariance: Matrix3<f64>,
    odometry: Option<Pose>,
    refused: u32,
}

impl PoseFilter {
    /// A filter for a robot that stands at a pose of the map, known to within the fix's deviations.
    #[must_use]
    pub fn new(start: &PoseMeasurement) -> Self {
        Self {
            pose: start.pose,
            covariance: noise(start),
            odometry: None,
            refused: 0,
        }
    }

    /// The estimate.
    #[must_use]
    pub const fn pose(&self) -> &Pose {
        &self.pose
    }

    /// Standard deviation of the position along the axis where it is larger, metres.
    #[must_use]
    pub fn sigma_m(&self) -> f64 {
        self.covariance[(0, 0)].max(self.covariance[(1, 1)]).sqrt()
    }

    /// Takes in where odometry has the robot, in its own frame, wherever that began. The first reading only sets where it
    /// began; one that is not finite is passed over.
    pub fn moved(&mut self, odometry: &Pose) {
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
        // A yaw that is off swings the step about.
        let transition = Matrix3::new(1.0, 0.0, -dy, 0.0, 1.0, dx, 0.0, 0.0, 1.0);
        let way_m = step.coords.norm();
        let along = ALONG_M2_PER_M * way_m + AT_REST_M2;
        let aside = ASIDE_M2_PER_M * way_m + ASIDE_M2_PER_RAD * turn.abs() + AT_REST_M2;
        let spread = (along - aside) * cos * sin;
        let added = Matrix3::new(
            along * cos * cos + aside * sin * sin,
            spread,
            0.0,
            spread,
            along * sin * sin + aside * cos * cos,
            0.0,
            0.0,
            0.0,
            TURN_RAD2_PER_M * way_m + TURN_RAD2_PER_RAD * turn.abs() + AT_REST_RAD2,
        );
        self.covariance = transition * self.covariance * transition.transpose() + added;
    }

    /// Takes in a fix of where the robot is now. Returns whether it was believed: one that is not finite never is, and
    /// one far off only after many like it.
    pub fn fixed(&mut self, fix: &PoseMeasurement) -> bool {
        if !(fix.pose.is_finite() && fix.sigma_m > 0.0 && fix.sigma_rad > 0.0) {
            return false;
        }
        let off = Vector3::new(
            fix.pose.x - self.pose.x,
            fix.pose.y - self.pose.y,
            wrap_angle(fix.pose.yaw - self.pose.yaw),
        );
        let noise = noise(fix);
        let Some(certainty) = (self.covariance + noise).try_inverse() else {
            return false;
        };
        if (off.transpose() * certainty * off)[0] > GATE_SIGMAS * GATE_SIGMAS {
            self.refused += 1;
            if self.refused >= BELIEVED_AFTER {
                *self = Self {
                    odometry: self.odometry,
                    ..Self::new(fix)
                };
                return true;
            }
            return false;
        }
        self.refused = 0;
        let gain = self.covariance * certainty;
        let moved = gain * off;
        self.pose = Pose {
            x: self.pose.x + moved.x,
            y: self.pose.y + moved.y,
            yaw: wrap_angle(self.pose.yaw + moved.z),
        };
        // Joseph's form stays symmetric and positive whatever is rounded.
        let kept = Matrix3::identity() - gain;
        self.covariance =
            kept * self.covariance * kept.transpose() + gain * noise * gain.transpose();
        true
    }
}

fn noise(fix: &PoseMeasurement) -> Matrix3<f64> {
    let position = fix.sigma_m * fix.sigma_m;
    Matrix3::from_diagonal(&Vector3::new(
        position,
        position,
        fix.sigma_rad * fix.sigma_rad,
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::FRAC_PI_2;

    const START: PoseMeasurement = PoseMeasurement {
        pose: Pose::new(3.0, -2.0, FRAC_PI_2),
        sigma_m: 0.01,
        sigma_rad: 0.005,
    };

    /// A quarter circle to the left of radius 2 m, in its own frame.
    fn arc(step: u32) -> Pose {
        let angle = FRAC_PI_2 * f64::from(step) / 100.0;
        let (sin, cos) = libm::sincos(angle);
        Pose::new(2.0 * sin, 2.0 * (1.0 - cos), angle)
    }

    #[test]
    fn without_fixes_it_is_odometry_moved_to_the_start() {
        let mut filter = PoseFilter::new(&START);
        (0..=100).for_each(|step| filter.moved(&arc(step)));
        let pose = filter.pose();
        assert!(
            (pose.x - 1.0).abs() < 1e-12 && pose.y.abs() < 1e-12,
            "{pose:?}"
        );
        assert!((wrap_angle(pose.yaw).abs() - core::f64::consts::PI).abs() < 1e-12);
        assert!(
            (0.02..0.08).contains(&filter.sigma_m()),
            "{}",
            filter.sigma_m()
        );
    }

    #[test]
    fn fixes_take_away_what_drifts() {
        let mut filter = PoseFilter::new(&START);
        for step in 0..=100 {
            // Odometry that counts 5 % too much.
            let true_pose = arc(step);
            filter.moved(&Pose::new(
                1.05 * true_pose.x,
                1.05 * true_pose.y,
                true_pose.yaw,
            ));
            let pose = START.pose.isometry() * true_pose.isometry();
            let fix = PoseMeasurement {
                pose: Pose::new(
                    pose.translation.x,
                    pose.translation.y,
                    pose.rotation.angle(),
                ),
                ..START
            };
            assert!(filter.fixed(&fix));
        }
        let pose = filter.pose();
        assert!(
            (pose.x - 1.0).abs() < 5e-3 && pose.y.abs() < 5e-3,
            "{pose:?}"
        );
    }

    #[test]
    fn one_wild_fix_is_not_believed_but_many_alike_are() {
        let mut filter = PoseFilter::new(&START);
        let wild = PoseMeasurement {
            pose: Pose::new(4.0, -2.0, FRAC_PI_2),
            ..START
        };
        for _ in 1..BELIEVED_AFTER {
            assert!(!filter.fixed(&wild));
            assert_eq!(*filter.pose(), START.pose);
        }
        assert!(filter.fixed(&wild));
        assert_eq!(*filter.pose(), wild.pose);
        let nan = PoseMeasurement {
            pose: Pose::new(f64::NAN, 0.0, 0.0),
            ..START
        };
        assert!(!filter.fixed(&nan));
        filter.moved(&Pose::new(f64::INFINITY, 0.0, 0.0));
        assert_eq!(*filter.pose(), wild.pose);
    }
}
