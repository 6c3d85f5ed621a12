//! Fits a disc to a cluster of lidar returns.

use nalgebra::Matrix2;

use super::cluster::Cluster;
use crate::geometry::{Point, Vector};

/// Least and largest radius of a moving obstacle, metres.
pub(super) const RADII_M: (f64, f64) = (0.1, 0.7);

/// Standard deviation of a return from a disc's outline, metres: noise of the range, and bodies that are not round.
const OUTLINE_DEVIATION_M: f64 = 0.02;
/// Standard deviation of the robot's position, metres, and of its heading, radians.
const PLACE_DEVIATION_M: f64 = 0.01;
const YAW_DEVIATION: f64 = 0.005;
/// Steps of the fit; each squares the remaining relative error.
const STEPS: usize = 3;

/// The centre of a disc with its covariance.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fit {
    pub center: Point,
    pub covariance: Matrix2<f64>,
}

/// A radius and its variance, metres and square metres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Radius {
    pub radius_m: f64,
    pub variance: f64,
}

impl Cluster {
    /// The direction to the centre of a disc of this radius, radians, and the standard deviation of the centre across it,
    /// metres.
    fn toward(&self, radius_m: f64, increment: f64) -> (f64, f64) {
        let distance = self.near_m + radius_m;
        // The edge is anywhere between two beams.
        let edge_m = distance * increment / 12.0_f64.sqrt();
        let half = libm::asin((radius_m / distance).min(1.0));
        let left = self.right + self.spread;
        match self.own_edges {
            [true, true] => (self.right + self.spread / 2.0, edge_m / 2.0_f64.sqrt()),
            // The error of the radius counts as much as that of the edge.
            [true, false] => (self.right + half, 2.0 * edge_m),
            [false, true] => (left - half, 2.0 * edge_m),
            [false, false] => (self.right + self.spread / 2.0, radius_m / 2.0),
        }
    }

    /// The approximate centre of a disc of this radius, by its direction and nearest return.
    pub fn rough_center(&self, robot: &Point, radius_m: f64, increment: f64) -> Point {
        let (direction, _) = self.toward(radius_m, increment);
        let (sin, cos) = libm::sincos(direction);
        robot + Vector::new(cos, sin) * (self.near_m + radius_m)
    }

    /// The disc of this radius that fits returns and edges best, by least squares (Gauss-Newton).
    pub fn fit<'a>(
        &self,
        points: &(impl Iterator<Item = &'a Point> + Clone),
        robot: &Point,
        radius_m: f64,
        increment: f64,
    ) -> Fit {
        let (direction, lateral_m) = self.toward(radius_m, increment);
        let (sin, cos) = libm::sincos(direction);
        let ahead = Vector::new(cos, sin);
        let across = Vector::new(-sin, cos);
        let distance = self.near_m + radius_m;
        let rough = robot + ahead * distance;
        let mut center = rough;
        let outline = OUTLINE_DEVIATION_M.powi(2).recip();
        let lateral = lateral_m.max(PLACE_DEVIATION_M / 2.0).powi(2).recip();
        let mut spread = Matrix2::identity();
        for _ in 0..STEPS {
            let mut normal = across * across.transpose() * lateral;
            let mut wanted = across * (-across.dot(&(center - robot)) * lateral);
            for point in points.clone() {
                let outward = center - point;
                let apart = outward.norm().max(1e-6);
                let outward = outward / apart;
                normal += outward * outward.transpose() * outline;
                wanted += outward * ((radius_m - apart) * outline);
            }
            let Some(inverse) = normal.try_inverse() else {
                break;
            };
            center += inverse * wanted;
            spread = inverse;
        }
        let is_sound = (center - rough).norm() < radius_m;
        if !is_sound {
            center = rough;
            spread = Matrix2::identity() * radius_m.powi(2);
        }
        let pose_m = PLACE_DEVIATION_M.powi(2) + (YAW_DEVIATION * distance).powi(2);
        Fit { center, covariance: spread + Matrix2::identity() * pose_m }
    }

    /// The radius of a disc whose nearest point is at a distance, metres, by the angle between its edges; nothing where an edge
    /// is hidden.
    ///
    /// A disc of radius `r` at a distance `d` from its outline has a half width `a` with `sin a = r / (d + r)`.
    pub fn radius(&self, distance_m: f64, increment: f64) -> Option<Radius> {
        let half = self.spread / 2.0;
        if self.own_edges != [true, true] || half > 1.2 {
            return None;
        }
        let sine = libm::sin(half);
        let radius_m = distance_m * sine / (1.0 - sine);
        let slope = distance_m * libm::cos(half) / (1.0 - sine).powi(2);
        let deviation = slope * increment / 24.0_f64.sqrt() + PLACE_DEVIATION_M;
        Some(Radius { radius_m, variance: deviation.powi(2) })
    }
}
