//! What is believed of the pose and of odometry's errors, and how well.
//!
//! An extended Kalman filter (Thrun, Burgard and Fox, "Probabilistic Robotics", 2005, section 3.3) over five numbers: the pose,
//! and two factors by which odometry's ways and turns are to be multiplied. Tracks lose some percent of their way to slip, the
//! same on the same ground, so the factors are worth learning: where the walls tell nothing of the place the pose then drifts by
//! what is left of the slip and not by all of it.

use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

use super::LocalizationSettings;
use crate::geometry::{Pose, wrap_angle};

/// Variance to the side, m^2 for each metre driven, and for each radian turned on the spot (our choice, as of the pose filter).
const ASIDE_M2_PER_M: f64 = 2e-4;
const ASIDE_M2_PER_RAD: f64 = 1e-4;
/// Variance of the yaw, rad^2 for each metre driven, for each radian turned, and for each second: a gyro's noise (our choice).
const TURN_RAD2_PER_M: f64 = 1e-5;
const TURN_RAD2_PER_RAD: f64 = 1e-4;
const TURN_RAD2_PER_S: f64 = 1e-6;
/// Variance that time alone adds to the position, m^2 for each second.
const AT_REST_M2_PER_S: f64 = 1e-7;
/// How the ground changes: variance of the factor of ways for each metre, and of that of turns for each radian (our choice).
const WAY_FACTOR_PER_M: f64 = 2e-6;
const TURN_FACTOR_PER_RAD: f64 = 1e-5;
/// The factors stay within these bounds.
const WAY_FACTOR: (f64, f64) = (0.3, 1.5);
const TURN_FACTOR: (f64, f64) = (0.7, 1.4);

type Square = SMatrix<f64, 5, 5>;

/// The estimate, in the frame of the map's grid.
#[derive(Clone, Copy, Debug)]
pub(super) struct PoseEkf {
    pub pose: Pose,
    way_factor: f64,
    turn_factor: f64,
    covariance: Square,
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
            way_factor: 1.0,
            turn_factor: 1.0,
            covariance: Square::from_diagonal(&sigmas.component_mul(&sigmas)),
        }
    }

    /// The same about odometry, at another place that is known as well as a start.
    pub fn reset_pose(&self, pose: Pose, settings: &LocalizationSettings) -> Self {
        let mut there = Self::new(pose, settings);
        there.way_factor = self.way_factor;
        there.turn_factor = self.turn_factor;
        for (row, column) in [(3, 3), (3, 4), (4, 3), (4, 4)] {
            there.covariance[(row, column)] = self.covariance[(row, column)];
        }
        there
    }

    pub fn pose_covariance(&self) -> Matrix3<f64> {
        self.covariance.fixed_view::<3, 3>(0, 0).into_owned()
    }

    /// By what odometry's ways and turns are multiplied.
    pub const fn factors(&self) -> (f64, f64) {
        (self.way_factor, self.turn_factor)
    }

    /// Takes in what odometry has the robot driven, from one pose to another, in a time, seconds.
    pub fn predict(
        &mut self,
        from: &Pose,
        to: &Pose,
        time_s: f64,
        settings: &LocalizationSettings,
    ) {
        let step = from.inverse_transform(&to.position());
        let turn = wrap_angle(to.yaw - from.yaw);
        // Half the difference that the factor makes to the turn swings the step.
        let (sin, cos) = libm::sincos(self.pose.yaw + 0.5 * (self.turn_factor - 1.0) * turn);
        let counted = (cos * step.x - sin * step.y, sin * step.x + cos * step.y);
        let (dx, dy) = (self.way_factor * counted.0, self.way_factor * counted.1);
        self.pose = Pose {
            x: self.pose.x + dx,
            y: self.pose.y + dy,
            yaw: wrap_angle(self.pose.yaw + self.turn_factor * turn),
        };
        let mut transition = Square::identity();
        (transition[(0, 2)], transition[(1, 2)]) = (-dy, dx);
        (transition[(0, 3)], transition[(1, 3)]) = counted;
        transition[(2, 4)] = turn;
        let (way_m, turned) = (step.coords.norm(), turn.abs());
        let at_rest = AT_REST_M2_PER_S * time_s;
        let along = settings.distance_sigma_m * settings.distance_sigma_m * way_m + at_rest;
        let aside = ASIDE_M2_PER_M * way_m + ASIDE_M2_PER_RAD * turned + at_rest;
        let spread = (along - aside) * cos * sin;
        let mut added = Square::zeros();
        added[(0, 0)] = along * cos * cos + aside * sin * sin;
        added[(1, 1)] = along * sin * sin + aside * cos * cos;
        (added[(0, 1)], added[(1, 0)]) = (spread, spread);
        added[(2, 2)] =
            TURN_RAD2_PER_M * way_m + TURN_RAD2_PER_RAD * turned + TURN_RAD2_PER_S * time_s;
        added[(3, 3)] = WAY_FACTOR_PER_M * way_m;
        added[(4, 4)] = TURN_FACTOR_PER_RAD * turned;
        self.covariance = transition * self.covariance * transition.transpose() + added;
    }

    /// Takes in where the walls have the robot, and how much they tell: their information on x, y and yaw. The pose given is the most
    /// probable one by both. Nothing is changed where the numbers do not allow it.
    pub fn correct(&mut self, pose: &Pose, information: &Matrix3<f64>) {
        let covariance = self.pose_covariance();
        let Some(certainty) = covariance.try_inverse() else {
            return;
        };
        let Some(of_both) = (certainty + information).try_inverse() else {
            return;
        };
        let moved = Vector3::new(
            pose.x - self.pose.x,
            pose.y - self.pose.y,
            wrap_angle(pose.yaw - self.pose.yaw),
        );
        // The factors follow the pose as far as they were tied to it.
        let tied = self.covariance.fixed_view::<2, 3>(3, 0).into_owned();
        let factors = tied * certainty * moved;
        self.pose = *pose;
        self.way_factor = (self.way_factor + factors.x).clamp(WAY_FACTOR.0, WAY_FACTOR.1);
        self.turn_factor = (self.turn_factor + factors.y).clamp(TURN_FACTOR.0, TURN_FACTOR.1);
        // The inverse of (covariance + information^-1), for information of any rank.
        let weight = information - information * of_both * information;
        let column = self.covariance.fixed_view::<5, 3>(0, 0).into_owned();
        let kept = self.covariance - column * weight * column.transpose();
        self.covariance = (kept + kept.transpose()) * 0.5;
    }
}
