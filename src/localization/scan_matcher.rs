//! Scan matching: Gauss-Newton minimisation of the distances between beam ends and mapped surfaces.

use nalgebra::{Matrix3, SymmetricEigen, Vector3};

use super::pose_filters::{offset, shifted};
use super::signed_distance_field::{DistanceSample, SignedDistanceField};
use super::{Agreement, DeskewedScan, LocalizationSettings};
use crate::geometry::Pose;

/// Largest number of iterations.
const MAX_ITERATIONS: u8 = 15;

/// An iteration that moves the pose by less than this, metres and radians, has converged.
const CONVERGED_M: f64 = 1e-4;
const CONVERGED_RAD: f64 = 2e-5;

/// Largest step of an iteration, metres and radians.
const MAX_STEP_M: f64 = 0.5;
const MAX_STEP_RAD: f64 = 0.3;

/// The first iteration widens the outlier tolerance by this many standard deviations of the prior pose; each further
/// iteration halves the addition.
const WIDE_SIGMAS: f64 = 3.0;

/// The information of a prior pose by its standard deviations, metres and radians.
pub(crate) fn information_of(sigma_m: f64, sigma_rad: f64) -> Matrix3<f64> {
    let position = 1.0 / (sigma_m * sigma_m);
    Matrix3::from_diagonal(&Vector3::new(position, position, 1.0 / (sigma_rad * sigma_rad)))
}

/// A scan matched to the map.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ScanMatch {
    /// The most probable pose given beams and prior.
    pub pose: Pose,
    /// Information of the beams on x, y and yaw at that pose.
    pub information: Matrix3<f64>,
    pub rms_m: f64,
    pub unobservable_directions: u8,
    pub iterations: u8,
}

/// Normal equations at a pose: sums over the beams within the tolerance.
#[derive(Clone, Copy, Debug, Default)]
struct NormalEquations {
    hessian: Matrix3<f64>,
    gradient: Vector3<f64>,
    weight: f64,
    squares: f64,
    /// Weighted squared distance of the beam ends from the robot.
    squared_range: f64,
}

/// Surfaces to which beam ends are matched.
pub(crate) trait Surfaces {
    /// Half of this is added to the tolerance of outliers, metres.
    fn resolution_m(&self) -> f64;

    /// Signed distance and gradient at a point in the frame of the surfaces, metres; none where they are unknown. The vector
    /// points from the robot to the point.
    fn sample(&self, x: f64, y: f64, from_robot: (f64, f64)) -> Option<DistanceSample>;
}

impl Surfaces for SignedDistanceField {
    #[inline]
    fn resolution_m(&self) -> f64 {
        self.frame.resolution_m
    }

    #[inline]
    fn sample(&self, x: f64, y: f64, _: (f64, f64)) -> Option<DistanceSample> {
        Self::sample(self, x, y)
    }
}

/// Matches a scan to a map.
pub(crate) struct ScanMatcher<'a, S = SignedDistanceField> {
    pub map: &'a S,
    pub scan: &'a DeskewedScan,
    pub settings: &'a LocalizationSettings,
}

impl<S: Surfaces> ScanMatcher<'_, S> {
    /// Moves a pose in the grid's frame to where the beams end on mapped surfaces. The prior pose counts by its information
    /// matrix, the inverse of its covariance.
    pub fn match_scan(
        &self,
        prior: &Pose,
        prior_information: &Matrix3<f64>,
        prior_sigma_m: f64,
    ) -> ScanMatch {
        self.match_scan_from(*prior, prior, prior_information, WIDE_SIGMAS * prior_sigma_m)
    }

    /// Matches a scan like [`Self::match_scan`], beginning at another pose than the prior one. The outlier tolerance begins
    /// wider by `wide_m`, metres.
    pub fn match_scan_from(
        &self,
        begin: Pose,
        prior: &Pose,
        prior_information: &Matrix3<f64>,
        mut wide_m: f64,
    ) -> ScanMatch {
        let narrow_m = self.tolerance_m();
        let (mut pose, mut iterations) = (begin, 0);
        loop {
            let equations = self.normal_equations(&pose, narrow_m + wide_m);
            let (information, gradient, unobservable_directions) = self.observable_part(&equations);
            let offset = offset(prior, &pose);
            let step =
                (prior_information + information).cholesky().map_or_else(Vector3::zeros, |whole| {
                    whole.solve(&(-gradient - prior_information * offset))
                });
            iterations += 1;
            let has_converged = step.xy().norm() < CONVERGED_M && step.z.abs() < CONVERGED_RAD;
            let is_narrow = wide_m < 0.1 * narrow_m;
            // The last step is not taken, so that the sums belong to the returned pose.
            if has_converged && is_narrow || iterations == MAX_ITERATIONS {
                let has_matches = equations.weight > 0.0;
                let rms_m =
                    if has_matches { (equations.squares / equations.weight).sqrt() } else { 0.0 };
                return ScanMatch { pose, information, rms_m, unobservable_directions, iterations };
            }
            let excess = (step.xy().norm() / MAX_STEP_M).max(step.z.abs() / MAX_STEP_RAD);
            let step = step / excess.max(1.0);
            pose = shifted(&pose, step.x, step.y, step.z);
            wide_m *= 0.5;
        }
    }

    /// Largest distance of a beam end from a surface that it matches, metres.
    fn tolerance_m(&self) -> f64 {
        self.settings.outlier_distance_m + 0.5 * self.map.resolution_m()
    }

    /// Sums in the order of the beams. Tukey's biweight of the distance is one on the surface and zero from the tolerance on.
    fn normal_equations(&self, pose: &Pose, tolerance_m: f64) -> NormalEquations {
        let (sin, cos) = libm::sincos(pose.yaw);
        let mut sums = NormalEquations::default();
        for hit in &self.scan.hits {
            let (x, y) = (cos * hit.end.x - sin * hit.end.y, sin * hit.end.x + cos * hit.end.y);
            let Some(sample) = self.map.sample(pose.x + x, pose.y + y, (x, y)) else {
                continue;
            };
            let ratio = sample.distance_m / tolerance_m;
            if ratio.abs() >= 1.0 {
                continue;
            }
            let root = 1.0 - ratio * ratio;
            let weight = root * root;
            let [gradient_x, gradient_y] = sample.gradient;
            let jacobian = Vector3::new(gradient_x, gradient_y, gradient_y * x - gradient_x * y);
            sums.hessian += jacobian * jacobian.transpose() * weight;
            sums.gradient += jacobian * (weight * sample.distance_m);
            sums.weight += weight;
            sums.squares += weight * sample.distance_m * sample.distance_m;
            sums.squared_range += weight * (x * x + y * y);
        }
        sums
    }

    /// Information and gradient along the observable directions, and the number of the others.
    ///
    /// Removes the directions of motion to which hardly any beam is sensitive. These are eigenvectors of the Hessian (Zhang,
    /// Kaess and Singh, "On Degeneracy of Optimization-based State Estimation Problems", ICRA 2016). The beams' mean range
    /// makes angles comparable to distances.
    fn observable_part(&self, sums: &NormalEquations) -> (Matrix3<f64>, Vector3<f64>, u8) {
        if sums.weight <= 0.0 {
            return (Matrix3::zeros(), Vector3::zeros(), 3);
        }
        let settings = self.settings;
        let arm_m = (sums.squared_range / sums.weight).sqrt().max(0.1);
        let to_scaled = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 1.0 / arm_m));
        let from_scaled = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, arm_m));
        let eigen = SymmetricEigen::new(to_scaled * sums.hessian * to_scaled);
        let threshold = settings.min_information * self.scan.hits.len() as f64;
        let (mut projection, mut unobservable_directions) = (Matrix3::zeros(), 0);
        for (direction, value) in eigen.eigenvectors.column_iter().zip(eigen.eigenvalues.iter()) {
            if *value >= threshold {
                projection += direction * direction.transpose();
            } else {
                unobservable_directions += 1;
            }
        }
        let scale = (settings.independent_beams / sums.weight).min(1.0)
            / (settings.beam_sigma_m * settings.beam_sigma_m);
        // Removes the asymmetry due to rounding.
        let hessian = projection * (to_scaled * sums.hessian * to_scaled) * projection;
        let hessian = (hessian + hessian.transpose()) * 0.5;
        let information = from_scaled * hessian * from_scaled * scale;
        let gradient = from_scaled * (projection * (to_scaled * sums.gradient)) * scale;
        (information, gradient, unobservable_directions)
    }
}

impl ScanMatcher<'_> {
    /// Numbers of beams that match the map at a pose.
    pub fn agreement(&self, pose: &Pose) -> Agreement {
        Agreement::of(self.map, self.scan, pose, self.tolerance_m())
    }
}
