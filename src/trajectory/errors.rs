//! Absolute and relative errors of a trajectory.

use serde::Serialize;

use super::ErrorStatistics;
use crate::geometry::{Point, Pose, wrap_angle};

/// Absolute trajectory error: distances after the rigid alignment with the smallest sum of squares.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct AbsoluteError {
    /// Number of compared poses.
    pub poses: usize,
    /// Distances of the positions, metres.
    pub position_m: ErrorStatistics,
    /// Differences of the yaw, radians. Where the positions do not determine the rotation, it is the mean difference of the yaws.
    pub yaw_rad: ErrorStatistics,
}

/// Relative pose error: of the motion from each pose to the next.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct RelativeError {
    /// Number of compared motions.
    pub motions: usize,
    /// Distances, metres.
    pub translation_m: ErrorStatistics,
    /// Angles, radians.
    pub rotation_rad: ErrorStatistics,
}

/// The absolute error of estimated poses against reference poses of the same times. None without poses.
///
/// The estimate is first moved by the rotation and translation that minimise the squared distances of the positions (Horn's
/// method in the plane; Sturm et al. 2012, equation 3). Positions of a robot that stands or turns in place have no direction:
/// where the root mean square distance after the alignment is above half the spread of the positions, the rotation of the yaws
/// is the mean difference of the yaws.
#[must_use]
pub fn absolute_error(pairs: &[(Pose, Pose)]) -> Option<AbsoluteError> {
    let (alignment, has_direction) = alignment(pairs)?;
    let rotation = if has_direction { alignment.yaw } else { mean_rotation(pairs) };
    let aligned = |(estimate, reference): &(Pose, Pose)| {
        let position = alignment.transform(&estimate.position());
        (
            (position - reference.position()).norm(),
            wrap_angle(estimate.yaw + rotation - reference.yaw).abs(),
        )
    };
    let (distances, angles) = pairs.iter().map(aligned).unzip();
    Some(AbsoluteError {
        poses: pairs.len(),
        position_m: ErrorStatistics::of(distances)?,
        yaw_rad: ErrorStatistics::of(angles)?,
    })
}

/// The mean difference of the yaws of the second poses from those of the first.
fn mean_rotation(pairs: &[(Pose, Pose)]) -> f64 {
    let (mut sines, mut cosines) = (0.0, 0.0);
    for (estimate, reference) in pairs {
        let (sin, cos) = libm::sincos(reference.yaw - estimate.yaw);
        (sines, cosines) = (sines + sin, cosines + cos);
    }
    libm::atan2(sines, cosines)
}

/// The rigid motion that brings the positions of the first poses of the pairs to those of the second ones, and whether the
/// positions determine its rotation.
fn alignment(pairs: &[(Pose, Pose)]) -> Option<(Pose, bool)> {
    if pairs.is_empty() {
        return None;
    }
    let count = pairs.len() as f64;
    let mean = |position: &dyn Fn(&(Pose, Pose)) -> Point| {
        let sum = pairs
            .iter()
            .map(position)
            .fold(Point::default(), |sum, point| Point::new(sum.x + point.x, sum.y + point.y));
        Point::new(sum.x / count, sum.y / count)
    };
    let from = mean(&|pair| pair.0.position());
    let to = mean(&|pair| pair.1.position());
    let (mut dot, mut cross) = (0.0, 0.0);
    let mut spreads = [0.0; 2];
    for (estimate, reference) in pairs {
        let (one, other) = (estimate.position() - from, reference.position() - to);
        spreads[0] += one.x * one.x + one.y * one.y;
        spreads[1] += other.x * other.x + other.y * other.y;
        dot += one.x * other.x + one.y * other.y;
        cross += one.x * other.y - one.y * other.x;
    }
    let squares = spreads[0] + spreads[1] - 2.0 * libm::hypot(dot, cross);
    let has_direction = 4.0 * squares < spreads[0].min(spreads[1]);
    let yaw = libm::atan2(cross, dot);
    let turned = Pose::new(0.0, 0.0, yaw).transform(&from);
    Some((Pose::new(to.x - turned.x, to.y - turned.y, yaw), has_direction))
}

/// The relative error of estimated poses against reference poses of the same times, from each to the next (Sturm et al. 2012,
/// equation 1, with an interval of one pose). None for fewer than two poses.
#[must_use]
pub fn relative_error(pairs: &[(Pose, Pose)]) -> Option<RelativeError> {
    let errors = pairs.windows(2).map(|step| {
        let estimated = step[0].0.inverse_transform_pose(&step[1].0);
        let reference = step[0].1.inverse_transform_pose(&step[1].1);
        difference(&reference, &estimated)
    });
    let (distances, angles): (Vec<f64>, Vec<f64>) = errors.unzip();
    Some(RelativeError {
        motions: distances.len(),
        translation_m: ErrorStatistics::of(distances)?,
        rotation_rad: ErrorStatistics::of(angles)?,
    })
}

/// Distance and angle of the motion from one relative pose to another.
pub(super) fn difference(reference: &Pose, estimated: &Pose) -> (f64, f64) {
    let error = reference.inverse_transform_pose(estimated);
    (libm::hypot(error.x, error.y), error.yaw.abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reference poses on a curve, and estimates in another frame with small errors.
    fn pairs() -> Vec<(Pose, Pose)> {
        let frame = Pose::new(3.0, -2.0, 0.8);
        let noise = |step: usize, phase: f64| 0.02 * libm::sin(1.7 * step as f64 + phase);
        let pair = |step: usize| {
            let along = 0.1 * step as f64;
            let reference = Pose::new(along, libm::sin(along), wrap_angle(0.2 * along));
            let off = Pose::new(noise(step, 0.0), noise(step, 1.0), noise(step, 2.0));
            (frame.transform_pose(&reference.transform_pose(&off)), reference)
        };
        (0..200).map(pair).collect()
    }

    /// The smallest root mean square distance over rotations, found by search, with the means at the same place.
    fn searched_rmse(pairs: &[(Pose, Pose)]) -> f64 {
        let count = pairs.len() as f64;
        let mean = |of: fn(&(Pose, Pose)) -> f64| pairs.iter().map(of).sum::<f64>() / count;
        let (ax, ay) = (mean(|p| p.0.x), mean(|p| p.0.y));
        let (bx, by) = (mean(|p| p.1.x), mean(|p| p.1.y));
        let rmse = |yaw: f64| {
            let (sin, cos) = libm::sincos(yaw);
            let squares: f64 = pairs
                .iter()
                .map(|(a, b)| {
                    let (x, y) = (a.x - ax, a.y - ay);
                    let (dx, dy) = (cos * x - sin * y - (b.x - bx), sin * x + cos * y - (b.y - by));
                    dx * dx + dy * dy
                })
                .sum();
            (squares / count).sqrt()
        };
        let (mut best, mut width) = (0.0, core::f64::consts::PI);
        while width > 1e-9 {
            let around = |step: i32| best + width * f64::from(step) / 20.0;
            let angles = (-20..=20).map(around);
            best = angles.min_by(|a, b| rmse(*a).total_cmp(&rmse(*b))).expect("41 angles");
            width *= 0.2;
        }
        rmse(best)
    }

    /// Whether the absolute error agrees with the search.
    fn absolute_agrees(computed: &[(Pose, Pose)], searched: &[(Pose, Pose)]) -> bool {
        let error = absolute_error(computed).expect("there are poses");
        (error.position_m.rmse - searched_rmse(searched)).abs() < 1e-8
    }

    #[test]
    fn absolute_error_equals_that_of_a_searched_alignment() {
        assert!(absolute_agrees(&pairs(), &pairs()));
    }

    #[test]
    fn one_wrong_pose_is_seen_by_the_search() {
        let mut wrong = pairs();
        wrong[77].0.x += 0.01;
        assert!(!absolute_agrees(&wrong, &pairs()));
    }

    /// The relative translation error by complex numbers: a pose is a position and a unit number.
    fn complex_relative_errors(pairs: &[(Pose, Pose)]) -> Vec<f64> {
        let step = |a: &Pose, b: &Pose| {
            let (dx, dy) = (b.x - a.x, b.y - a.y);
            let (c, s) = (libm::cos(a.yaw), libm::sin(a.yaw));
            (dx * c + dy * s, dy * c - dx * s)
        };
        let error = |two: &[(Pose, Pose)]| {
            let (e, r) = (step(&two[0].0, &two[1].0), step(&two[0].1, &two[1].1));
            ((e.0 - r.0).powi(2) + (e.1 - r.1).powi(2)).sqrt()
        };
        pairs.windows(2).map(error).collect()
    }

    fn relative_agrees(computed: &[(Pose, Pose)], checked: &[(Pose, Pose)]) -> bool {
        let error = relative_error(computed).expect("there are poses");
        let expected = complex_relative_errors(checked);
        let mean = expected.iter().sum::<f64>() / expected.len() as f64;
        let max = expected.iter().fold(0.0, |most: f64, it| most.max(*it));
        (error.translation_m.mean - mean).abs() < 1e-12
            && (error.translation_m.max - max).abs() < 1e-12
    }

    #[test]
    fn relative_error_equals_an_own_formula() {
        assert!(relative_agrees(&pairs(), &pairs()));
        let turned: Vec<_> = pairs().iter().map(|(one, _)| (*one, *one)).collect();
        let error = relative_error(&turned).expect("there are poses");
        assert!(error.translation_m.max < 1e-12 && error.rotation_rad.max < 1e-12);
    }

    #[test]
    fn one_wrong_yaw_is_seen_by_the_own_formula() {
        let mut wrong = pairs();
        wrong[30].1.yaw += 0.05;
        assert!(!relative_agrees(&wrong, &pairs()));
    }

    #[test]
    fn no_poses_have_no_error() {
        assert_eq!(absolute_error(&[]), None);
        assert_eq!(relative_error(&pairs()[..1]), None);
    }

    #[test]
    fn yaw_error_of_robot_that_stands_or_turns_in_place_is_that_of_its_yaws() {
        let standing = vec![(Pose::new(1.0, 1.0, 0.3), Pose::new(2.0, 1.0, 0.3)); 3];
        let error = absolute_error(&standing).expect("there are poses");
        assert!(error.position_m.max < 1e-12 && error.yaw_rad.max < 1e-12);
        let turning = |step: u32| {
            let phase = f64::from(step);
            let reference = Pose::new(2.0, 1.0, wrap_angle(0.1 * phase));
            let (x, y) = (0.005 * libm::sin(2.3 * phase), 0.005 * libm::sin(3.1 * phase));
            let off = Pose::new(x, y, 0.01 * libm::sin(1.3 * phase));
            (reference.transform_pose(&off), reference)
        };
        let error = absolute_error(&(0..100).map(turning).collect::<Vec<_>>());
        let error = error.expect("there are poses");
        assert!(error.yaw_rad.max < 0.011 && error.position_m.max < 0.011, "{error:?}");
    }
}
