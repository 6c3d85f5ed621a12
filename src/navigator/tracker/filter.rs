//! Kalman filter of constant velocity in the plane.

use nalgebra::{Matrix2, Matrix4, SMatrix, SVector};

use crate::geometry::{Point, Vector};

/// Variance of the first velocity, (m/s)^2 on each axis: people walk at about 1 m/s.
const FIRST_SPEED_VARIANCE: f64 = 1.0;

/// A measured position, such as the centre of a disc, with its covariance.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fit {
    pub center: Point,
    pub covariance: Matrix2<f64>,
}

/// An estimate of position and velocity with its covariance.
///
/// The model is white noise of acceleration, in m^2/s^3 (Bar-Shalom, Li and Kirubarajan, Estimation with Applications to
/// Tracking and Navigation, 2001, section 6.2.2).
#[derive(Clone, Debug)]
pub(super) struct Filter {
    /// Position, metres, then velocity, metres per second.
    state: SVector<f64, 4>,
    covariance: SMatrix<f64, 4, 4>,
}

impl Filter {
    /// A filter after one measured position, with unknown velocity.
    pub fn new(first: &Fit) -> Self {
        let mut covariance = Matrix4::identity() * FIRST_SPEED_VARIANCE;
        covariance.fixed_view_mut::<2, 2>(0, 0).copy_from(&first.covariance);
        Self { state: SVector::from([first.center.x, first.center.y, 0.0, 0.0]), covariance }
    }

    /// Predicts over a time, seconds, with noise of acceleration, m^2/s^3.
    pub fn predict(&mut self, time_s: f64, noise: f64) {
        let mut motion = Matrix4::identity();
        motion.fixed_view_mut::<2, 2>(0, 2).copy_from(&(Matrix2::identity() * time_s));
        self.state = motion * self.state;
        self.covariance = motion * self.covariance * motion.transpose();
        self.add_noise(time_s, noise);
    }

    /// Increases the covariance by noise of acceleration, m^2/s^3, over a time, seconds.
    pub fn add_noise(&mut self, time_s: f64, noise: f64) {
        let identity = Matrix2::identity();
        let mut add = |row, column, value: f64| {
            let mut block = self.covariance.fixed_view_mut::<2, 2>(row, column);
            block += identity * (noise * value);
        };
        add(0, 0, time_s.powi(3) / 3.0);
        add(0, 2, time_s.powi(2) / 2.0);
        add(2, 0, time_s.powi(2) / 2.0);
        add(2, 2, time_s);
    }

    /// The squared Mahalanobis distance of a measured position from the expected one.
    pub fn squared_deviations(&self, measured: &Fit) -> f64 {
        let error = (measured.center - self.center()).to_column();
        let sum = self.covariance.fixed_view::<2, 2>(0, 0) + measured.covariance;
        sum.try_inverse().map_or(f64::INFINITY, |inverse| error.dot(&(inverse * error)))
    }

    /// Corrects with a measured position.
    pub fn correct(&mut self, measured: &Fit) {
        let error = (measured.center - self.center()).to_column();
        let sum = self.covariance.fixed_view::<2, 2>(0, 0) + measured.covariance;
        let Some(inverse) = sum.try_inverse() else {
            return;
        };
        let cross = self.covariance.fixed_view::<4, 2>(0, 0).into_owned();
        let gain = cross * inverse;
        self.state += gain * error;
        let left = self.covariance - gain * cross.transpose();
        // Keeps the matrix symmetric in spite of rounding.
        self.covariance = (left + left.transpose()) * 0.5;
    }

    /// Shifts the position and keeps the velocity.
    pub fn shift(&mut self, by: &Vector) {
        let mut position = self.state.fixed_rows_mut::<2>(0);
        position += by.to_column();
    }

    /// Estimated position.
    pub fn center(&self) -> Point {
        Point::new(self.state[0], self.state[1])
    }

    /// Estimated velocity, metres per second.
    pub fn velocity(&self) -> Vector {
        Vector::new(self.state[2], self.state[3])
    }

    /// Standard deviation of the speed in the direction of motion, metres per second.
    pub fn speed_deviation(&self) -> f64 {
        let velocity = self.velocity().to_column();
        let spread = self.covariance.fixed_view::<2, 2>(2, 2).into_owned();
        let squared = velocity.norm_squared();
        if squared > 0.0 {
            (velocity.dot(&(spread * velocity)) / squared).max(0.0).sqrt()
        } else {
            spread.trace().max(0.0).sqrt()
        }
    }
}
