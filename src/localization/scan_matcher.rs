//! Laying a revolution on the map: Gauss and Newton's method on the beams' distances to the walls.

use nalgebra::{Matrix3, SymmetricEigen, Vector3};

use super::LocalizationSettings;
use super::deskewed_scan::Hit;
use super::signed_distance_field::SignedDistanceField;
use crate::geometry::{Pose, wrap_angle};

/// Most rounds of one matching.
const MOST_ROUNDS: u8 = 15;

/// A round that moves the pose by less than this, metres and radians, is the last.
const STILL_M: f64 = 1e-4;
const STILL_RAD: f64 = 2e-5;

/// No round moves the pose farther than this, metres and radians.
const STRIDE_M: f64 = 0.5;
const STRIDE_RAD: f64 = 0.3;

/// In the first rounds beams up to so many standard deviations of the pose farther from a wall count as well; half as many in
/// each round after.
const WIDE_SIGMAS: f64 = 3.0;

/// A pose laid on the map.
#[derive(Clone, Copy, Debug)]
pub(super) struct Matched {
    /// The most probable pose by beams and prior.
    pub pose: Pose,
    /// What the beams tell of x, y and yaw there.
    pub information: Matrix3<f64>,
    pub rms_m: f64,
    pub unobservable_directions: u8,
    pub iterations: u8,
}

/// What the beams say at a pose: sums over those that count.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    hessian: Matrix3<f64>,
    gradient: Vector3<f64>,
    weight: f64,
    squares: f64,
    /// Squared distance of the ends from the robot.
    reach: f64,
}

/// Moves a pose of the grid's frame to where the beams end on walls, held by the prior: that pose with its certainty, the inverse of
/// its covariance.
pub(super) fn matched(
    walls: &SignedDistanceField,
    hits: &[Hit],
    prior: &Pose,
    certainty: &Matrix3<f64>,
    prior_sigma_m: f64,
    settings: &LocalizationSettings,
) -> Matched {
    let narrow_m = tolerance_m(walls, settings);
    let mut wide_m = WIDE_SIGMAS * prior_sigma_m;
    let (mut pose, mut iterations) = (*prior, 0);
    loop {
        let sums = sums(walls, hits, &pose, narrow_m + wide_m);
        let told = told(&sums, hits.len(), settings);
        let off = Vector3::new(
            pose.x - prior.x,
            pose.y - prior.y,
            wrap_angle(pose.yaw - prior.yaw),
        );
        let step = (certainty + told.information)
            .cholesky()
            .map_or_else(Vector3::zeros, |whole| {
                whole.solve(&(-told.gradient - certainty * off))
            });
        iterations += 1;
        let is_still = step.xy().norm() < STILL_M && step.z.abs() < STILL_RAD;
        let is_narrow = wide_m < 0.1 * narrow_m;
        // The last word is of a pose whose sums are known.
        if is_still && is_narrow || iterations == MOST_ROUNDS {
            return Matched {
                pose,
                information: told.information,
                rms_m: if sums.weight > 0.0 {
                    (sums.squares / sums.weight).sqrt()
                } else {
                    0.0
                },
                unobservable_directions: told.unseen,
                iterations,
            };
        }
        let stride = (step.xy().norm() / STRIDE_M).max(step.z.abs() / STRIDE_RAD);
        let step = step / stride.max(1.0);
        pose = Pose {
            x: pose.x + step.x,
            y: pose.y + step.y,
            yaw: wrap_angle(pose.yaw + step.z),
        };
        wide_m *= 0.5;
    }
}

/// Beams that end no farther from a wall than this, metres, are taken to end on it.
pub(super) fn tolerance_m(walls: &SignedDistanceField, settings: &LocalizationSettings) -> f64 {
    settings.outlier_distance_m + 0.5 * walls.resolution_m()
}

/// In the order of the beams. Each weighs by Tukey's function of its distance: one on the wall, zero from the tolerance on.
fn sums(walls: &SignedDistanceField, hits: &[Hit], pose: &Pose, tolerance_m: f64) -> Sums {
    let (sin, cos) = libm::sincos(pose.yaw);
    let mut sums = Sums::default();
    for hit in hits {
        let (x, y) = (
            cos * hit.end.x - sin * hit.end.y,
            sin * hit.end.x + cos * hit.end.y,
        );
        let Some(level) = walls.level(pose.x + x, pose.y + y) else {
            continue;
        };
        let share = level.distance_m / tolerance_m;
        if share.abs() >= 1.0 {
            continue;
        }
        let root = 1.0 - share * share;
        let weight = root * root;
        let [along_x, along_y] = level.slope;
        let slope = Vector3::new(along_x, along_y, along_y * x - along_x * y);
        sums.hessian += slope * slope.transpose() * weight;
        sums.gradient += slope * (weight * level.distance_m);
        sums.weight += weight;
        sums.squares += weight * level.distance_m * level.distance_m;
        sums.reach += weight * (x * x + y * y);
    }
    sums
}

/// What the beams tell, without the directions that hardly any of them would notice a motion along.
struct Told {
    information: Matrix3<f64>,
    gradient: Vector3<f64>,
    unseen: u8,
}

/// The directions are those of the Hessian's eigenvectors, as of Zhang, Kaess and Singh, "On Degeneracy of Optimization-based State
/// Estimation Problems" (ICRA 2016), with angles made comparable to ways by the beams' mean length.
fn told(sums: &Sums, beams: usize, settings: &LocalizationSettings) -> Told {
    if sums.weight <= 0.0 {
        return Told {
            information: Matrix3::zeros(),
            gradient: Vector3::zeros(),
            unseen: 3,
        };
    }
    let arm_m = (sums.reach / sums.weight).sqrt().max(0.1);
    let even = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 1.0 / arm_m));
    let back = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, arm_m));
    let eigen = SymmetricEigen::new(even * sums.hessian * even);
    let least = settings.min_information * beams as f64;
    let (mut kept, mut unseen) = (Matrix3::zeros(), 0);
    for (direction, value) in eigen
        .eigenvectors
        .column_iter()
        .zip(eigen.eigenvalues.iter())
    {
        if *value >= least {
            kept += direction * direction.transpose();
        } else {
            unseen += 1;
        }
    }
    let scale = (settings.independent_beams / sums.weight).min(1.0)
        / (settings.beam_sigma_m * settings.beam_sigma_m);
    // Rounding must not leave it unsymmetric.
    let hessian = kept * (even * sums.hessian * even) * kept;
    let hessian = (hessian + hessian.transpose()) * 0.5;
    Told {
        information: back * hessian * back * scale,
        gradient: back * (kept * (even * sums.gradient)) * scale,
        unseen,
    }
}
