//! Extended Kalman filter for the pose and the scale errors of odometry.
//!
//! The filter (Thrun, Burgard and Fox, "Probabilistic Robotics", 2005, section 3.3) has five states: the pose, and one scale
//! factor each for odometry's distances and turns. Tracks lose some percent of their travel to slip, and this is constant on
//! constant terrain. With learned factors, the pose drifts only by the residual slip where the map gives no information.

use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

use super::LocalizationSettings;
use crate::geometry::{Pose, wrap_angle};

/// Lateral variance, m^2 per metre driven and per radian turned in place (our choice, as in the navigator's pose filter).
const LATERAL_M2_PER_M: f64 = 2e-4;
const LATERAL_M2_PER_RAD: f64 = 1e-4;
/// Yaw variance, rad^2 per metre driven, per radian turned and per second: gyro noise (our choice).
const TURN_RAD2_PER_M: f64 = 1e-5;
const TURN_RAD2_PER_RAD: f64 = 1e-4;
const TURN_RAD2_PER_S: f64 = 1e-6;
/// Position variance at rest, m^2 per second.
const AT_REST_M2_PER_S: f64 = 1e-7;
/// Change of terrain: variance of the distance scale per metre, and of the turn scale per radian (our choice).
const DISTANCE_SCALE_PER_M: f64 = 2e-6;
const TURN_SCALE_PER_RAD: f64 = 1e-5;
/// Bounds of the scale factors.
const DISTANCE_SCALE: (f64, f64) = (0.3, 1.5);
const TURN_SCALE: (f64, f64) = (0.7, 1.4);

type Covariance = SMatrix<f64, 5, 5>;

/// The state estimate, with the pose in the frame of the map's grid.
#[derive(Clone, Copy, Debug)]
pub(super) struct PoseEkf {
    pub pose: Pose,
    distance_scale: f64,
    turn_scale: f64,
    covariance: Covariance,
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
        }
    }

    /// Returns the filter at another pose with the initial uncertainty. The scale factors and their covariance are kept.
    pub fn reset_pose(&self, pose: Pose, settings: &LocalizationSettings) -> Self {
        let mut reset = Self::new(pose, settings);
        reset.distance_scale = self.distance_scale;
        reset.turn_scale = self.turn_scale;
        for (row, column) in [(3, 3), (3, 4), (4, 3), (4, 4)] {
            reset.covariance[(row, column)] = self.covariance[(row, column)];
        }
        reset
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
        self.pose = Pose {
            x: self.pose.x + dx,
            y: self.pose.y + dy,
            yaw: wrap_angle(self.pose.yaw + self.turn_scale * turn),
        };
        let mut transition = Covariance::identity();
        (transition[(0, 2)], transition[(1, 2)]) = (-dy, dx);
        (transition[(0, 3)], transition[(1, 3)]) = unscaled;
        transition[(2, 4)] = turn;
        let (distance_m, turned) = (step.coords.norm(), turn.abs());
        let at_rest = AT_REST_M2_PER_S * time_s;
        let along = settings.distance_sigma_m * settings.distance_sigma_m * distance_m + at_rest;
        let lateral = LATERAL_M2_PER_M * distance_m + LATERAL_M2_PER_RAD * turned + at_rest;
        let cross = (along - lateral) * cos * sin;
        let mut noise = Covariance::zeros();
        noise[(0, 0)] = along * cos * cos + lateral * sin * sin;
        noise[(1, 1)] = along * sin * sin + lateral * cos * cos;
        (noise[(0, 1)], noise[(1, 0)]) = (cross, cross);
        noise[(2, 2)] =
            TURN_RAD2_PER_M * distance_m + TURN_RAD2_PER_RAD * turned + TURN_RAD2_PER_S * time_s;
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
        let correction = Vector3::new(
            pose.x - self.pose.x,
            pose.y - self.pose.y,
            wrap_angle(pose.yaw - self.pose.yaw),
        );
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
