//! Extended Kalman filters for the pose: of the localizer, and of odometry with measured poses.
//!
//! Both follow Thrun, Burgard and Fox, "Probabilistic Robotics", 2005, section 3.3, and differ in their measurements.

use nalgebra::{Matrix2, Matrix3, SMatrix, SVector, Vector3};

use super::LocalizationSettings;
use crate::geometry::{Pose, wrap_angle};

/// Variance across the motion, m^2 per metre driven and per radian turned in place (our choice).
const LATERAL_M2_PER_M: f64 = 2e-4;
const LATERAL_M2_PER_RAD: f64 = 1e-4;
/// Yaw variance, rad^2 per metre driven (our choice).
const YAW_RAD2_PER_M: f64 = 1e-5;

/// Variances along and across a step, square metres, in the frame in which the step has this direction.
fn step_noise(along: f64, across: f64, sin: f64, cos: f64) -> Matrix2<f64> {
    let cross = (along - across) * cos * sin;
    Matrix2::new(
        along * cos * cos + across * sin * sin,
        cross,
        cross,
        along * sin * sin + across * cos * cos,
    )
}

/// Differences of x, y and yaw from one pose to another.
pub(super) fn offset(from: &Pose, to: &Pose) -> Vector3<f64> {
    Vector3::new(to.x - from.x, to.y - from.y, wrap_angle(to.yaw - from.yaw))
}

/// A pose changed by differences of x, y and yaw.
pub(super) fn shifted(pose: &Pose, dx: f64, dy: f64, turn: f64) -> Pose {
    Pose { x: pose.x + dx, y: pose.y + dy, yaw: wrap_angle(pose.yaw + turn) }
}

/// Yaw variance of the localizer, rad^2 per radian turned and per second: gyro noise (our choice).
const TURN_RAD2_PER_RAD: f64 = 1e-4;

/// Variances of odometry besides its scale error and that along the motion, which are settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct OdometryNoise {
    /// Variance across the motion, m^2 per metre driven.
    pub lateral_m2_per_m: f64,
    /// Variance of the position, m^2 per radian turned.
    pub lateral_m2_per_rad: f64,
    /// Variance of the yaw, rad^2 per metre driven.
    pub yaw_rad2_per_m: f64,
    /// Variance of the yaw, rad^2 per radian turned.
    pub yaw_rad2_per_rad: f64,
}

impl OdometryNoise {
    /// Odometry whose yaw is that of a gyro.
    pub const GYRO: Self = Self {
        lateral_m2_per_m: LATERAL_M2_PER_M,
        lateral_m2_per_rad: LATERAL_M2_PER_RAD,
        yaw_rad2_per_m: YAW_RAD2_PER_M,
        yaw_rad2_per_rad: TURN_RAD2_PER_RAD,
    };

    /// Odometry of wheels alone, whose stamps differ from those of the lidar: 3 cm and 0.03 rad after one metre, and 0.1 rad after
    /// one radian. This is about the noise of 0.1 per step that GMapping assumes, at steps of 0.1 m and one radian.
    pub const WHEELS: Self = Self {
        lateral_m2_per_m: 1e-3,
        lateral_m2_per_rad: 1e-3,
        yaw_rad2_per_m: 1e-3,
        yaw_rad2_per_rad: 1e-2,
    };
}

const TURN_RAD2_PER_S: f64 = 1e-6;
/// Position variance of the localizer at rest, m^2 per second.
const AT_REST_M2_PER_S: f64 = 1e-7;
/// Change of terrain: variance of the distance scale per metre, and of the turn scale per radian (our choice).
const DISTANCE_SCALE_PER_M: f64 = 2e-6;
const TURN_SCALE_PER_RAD: f64 = 1e-5;
/// Bounds of the scale factors.
const DISTANCE_SCALE: (f64, f64) = (0.3, 1.5);
const TURN_SCALE: (f64, f64) = (0.5, 2.0);

type Covariance = SMatrix<f64, 5, 5>;

/// The state estimate of the localizer, with the pose in the frame of the map's grid.
///
/// The states are the pose, and one scale factor each for odometry's distances and turns. Tracks lose some percent of their
/// travel to slip, and this is constant on constant terrain. With learned factors, the pose drifts only by the residual slip
/// where the map gives no information.
#[derive(Clone, Copy, Debug)]
pub(super) struct PoseEkf {
    pub pose: Pose,
    distance_scale: f64,
    turn_scale: f64,
    covariance: Covariance,
    pub noise: OdometryNoise,
}

impl PoseEkf {
    pub fn new(pose: Pose, settings: &LocalizationSettings) -> Self {
        let sigmas = SVector::<f64, 5>::from([
            settings.initial_sigma_m,
            settings.initial_sigma_m,
            settings.initial_sigma_rad,
            settings.distance_scale_sigma,
            settings.turn_scale_sigma,
        ]);
        Self {
            pose,
            distance_scale: 1.0,
            turn_scale: 1.0,
            covariance: Covariance::from_diagonal(&sigmas.component_mul(&sigmas)),
            noise: OdometryNoise::GYRO,
        }
    }

    /// Returns the filter at another pose with the initial uncertainty. The scale factors and their covariance are kept.
    pub fn reset_pose(&self, pose: Pose, settings: &LocalizationSettings) -> Self {
        let mut reset = Self::new(pose, settings);
        reset.distance_scale = self.distance_scale;
        reset.turn_scale = self.turn_scale;
        reset.noise = self.noise;
        for (row, column) in [(3, 3), (3, 4), (4, 3), (4, 4)] {
            reset.covariance[(row, column)] = self.covariance[(row, column)];
        }
        reset
    }

    /// Adds to the variance of the pose: standard deviations in metres and radians.
    pub fn widen(&mut self, sigma_m: f64, sigma_rad: f64) {
        for (index, sigma) in [sigma_m, sigma_m, sigma_rad].into_iter().enumerate() {
            self.covariance[(index, index)] += sigma * sigma;
        }
    }

    pub fn pose_covariance(&self) -> Matrix3<f64> {
        self.covariance.fixed_view::<3, 3>(0, 0).into_owned()
    }

    /// The scale factors of odometry's distances and turns.
    pub const fn odometry_scale(&self) -> (f64, f64) {
        (self.distance_scale, self.turn_scale)
    }

    /// Predicts the state after odometry moved from one pose to another within a time, seconds.
    pub fn predict(
        &mut self,
        from: &Pose,
        to: &Pose,
        time_s: f64,
        settings: &LocalizationSettings,
    ) {
        let step = from.inverse_transform(&to.position());
        let turn = wrap_angle(to.yaw - from.yaw);
        // The step's direction changes by half of the additional turn.
        let (sin, cos) = libm::sincos(self.pose.yaw + 0.5 * (self.turn_scale - 1.0) * turn);
        let unscaled = (cos * step.x - sin * step.y, sin * step.x + cos * step.y);
        let (dx, dy) = (self.distance_scale * unscaled.0, self.distance_scale * unscaled.1);
        self.pose = shifted(&self.pose, dx, dy, self.turn_scale * turn);
        let mut transition = Covariance::identity();
        (transition[(0, 2)], transition[(1, 2)]) = (-dy, dx);
        (transition[(0, 3)], transition[(1, 3)]) = unscaled;
        transition[(2, 4)] = turn;
        let (distance_m, turned) = (step.to_vector().norm(), turn.abs());
        let at_rest = AT_REST_M2_PER_S * time_s;
        let along = settings.distance_sigma_m * settings.distance_sigma_m * distance_m + at_rest;
        let OdometryNoise { lateral_m2_per_m, lateral_m2_per_rad, .. } = self.noise;
        let OdometryNoise { yaw_rad2_per_m, yaw_rad2_per_rad, .. } = self.noise;
        let lateral = lateral_m2_per_m * distance_m + lateral_m2_per_rad * turned + at_rest;
        let mut noise = Covariance::zeros();
        noise.fixed_view_mut::<2, 2>(0, 0).copy_from(&step_noise(along, lateral, sin, cos));
        noise[(2, 2)] =
            yaw_rad2_per_m * distance_m + yaw_rad2_per_rad * turned + TURN_RAD2_PER_S * time_s;
        noise[(3, 3)] = DISTANCE_SCALE_PER_M * distance_m;
        noise[(4, 4)] = TURN_SCALE_PER_RAD * turned;
        self.covariance = transition * self.covariance * transition.transpose() + noise;
    }

    /// Corrects the state by a scan match: the matched pose, which is the most probable one given filter and scan, and the
    /// information of the scan on x, y and yaw. The state is unchanged if a matrix is singular.
    pub fn correct(&mut self, pose: &Pose, information: &Matrix3<f64>) {
        let covariance = self.pose_covariance();
        let Some(pose_information) = covariance.try_inverse() else {
            return;
        };
        let Some(fused) = (pose_information + information).try_inverse() else {
            return;
        };
        let correction = offset(&self.pose, pose);
        // The scale factors change by their correlation with the pose.
        let correlation = self.covariance.fixed_view::<2, 3>(3, 0).into_owned();
        let scales = correlation * pose_information * correction;
        self.pose = *pose;
        self.distance_scale =
            (self.distance_scale + scales.x).clamp(DISTANCE_SCALE.0, DISTANCE_SCALE.1);
        self.turn_scale = (self.turn_scale + scales.y).clamp(TURN_SCALE.0, TURN_SCALE.1);
        // The inverse of (covariance + information^-1), for information of any rank.
        let gain = information - information * fused * information;
        let column = self.covariance.fixed_view::<5, 3>(0, 0).into_owned();
        let corrected = self.covariance - column * gain * column.transpose();
        self.covariance = (corrected + corrected.transpose()) * 0.5;
    }
}

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

/// Variance of the filter along the motion, m^2 per metre driven: 3 cm after one metre, the slip of tracks (our choice).
const ALONG_M2_PER_M: f64 = 9e-4;
/// Yaw variance of the filter, rad^2 per radian turned: a gyro's scale error (our choice).
const YAW_RAD2_PER_RAD: f64 = 4e-4;
/// Variance that each reading adds even at rest, m^2 and rad^2, so that no measurement ever loses all weight.
const AT_REST_M2: f64 = 1e-8;
const AT_REST_RAD2: f64 = 1e-8;
/// A measurement further off than this many standard deviations is an outlier: one in ten thousand valid ones.
const GATE_SIGMAS: f64 = 4.6;
/// This many outliers in a row are accepted: the filter itself is wrong then.
const ACCEPTED_AFTER: u32 = 10;

/// An estimate of the robot's pose in the map frame, from drifting odometry and absolute pose measurements.
///
/// Odometry is smooth and drifts; a measurement, by a scan matcher or a total station, is noisy and does not drift. The input
/// is in REP-105's odom frame, the output in the map frame.
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
        self.pose = shifted(&self.pose, dx, dy, turn);
        // An error of the yaw rotates the step.
        let transition = Matrix3::new(1.0, 0.0, -dy, 0.0, 1.0, dx, 0.0, 0.0, 1.0);
        let driven_m = step.to_vector().norm();
        let along = ALONG_M2_PER_M * driven_m + AT_REST_M2;
        let across = LATERAL_M2_PER_M * driven_m + LATERAL_M2_PER_RAD * turn.abs() + AT_REST_M2;
        let mut added = Matrix3::zeros();
        added.fixed_view_mut::<2, 2>(0, 0).copy_from(&step_noise(along, across, sin, cos));
        added[(2, 2)] = YAW_RAD2_PER_M * driven_m + YAW_RAD2_PER_RAD * turn.abs() + AT_REST_RAD2;
        self.covariance = transition * self.covariance * transition.transpose() + added;
    }

    /// Corrects with a measured pose and returns whether it was accepted. It rejects one that is not finite, and an outlier
    /// unless many in a row were outliers.
    pub fn correct(&mut self, measured: &PoseMeasurement) -> bool {
        if !(measured.pose.is_finite() && measured.sigma_m > 0.0 && measured.sigma_rad > 0.0) {
            return false;
        }
        let off = offset(&self.pose, &measured.pose);
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
        self.pose = shifted(&self.pose, shift.x, shift.y, shift.z);
        // Joseph's form stays symmetric and positive definite in spite of rounding.
        let kept = Matrix3::identity() - gain;
        self.covariance =
            kept * self.covariance * kept.transpose() + gain * noise * gain.transpose();
        true
    }
}

fn noise(measured: &PoseMeasurement) -> Matrix3<f64> {
    let position = measured.sigma_m * measured.sigma_m;
    let yaw = measured.sigma_rad * measured.sigma_rad;
    Matrix3::from_diagonal(&Vector3::new(position, position, yaw))
}
