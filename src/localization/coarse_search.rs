//! A search around a predicted pose, before the scan matcher: its steps converge only from poses that are already near.
//!
//! This is correlative scan matching (Olson, "Real-Time Correlative Scan Matching", ICRA 2009) with a small window.

use super::DeskewedScan;
use super::signed_distance_field::SignedDistanceField;
use crate::geometry::{Point, Pose, wrap_angle};

/// Steps of the search, metres and radians, and its largest extent to each side.
const STEP_M: f64 = 0.08;
const STEP_RAD: f64 = 0.02;
const MAX_EXTENT_M: f64 = 0.8;
const MAX_EXTENT_RAD: f64 = 0.6;

/// The window in standard deviations of the predicted pose.
const SIGMAS: f64 = 3.0;

/// Number of beams that are scored.
const BEAMS: usize = 60;

/// Beam ends up to this distance from a surface count on a map, metres.
const SCORED_DISTANCE_M: f64 = 0.2;

/// The pose on a map around a predicted one from which the beams end nearest to surfaces. The prior counts by its standard
/// deviations, metres and radians.
pub(super) fn search_map(
    map: &SignedDistanceField,
    scan: &DeskewedScan,
    prior: &Pose,
    sigmas: (f64, f64),
) -> Pose {
    coarse_search(scan.hits.iter().map(|hit| hit.end), prior, sigmas, |x, y| {
        let distance_m = map.cell_distance_m(x, y).unwrap_or(SCORED_DISTANCE_M);
        (1.0 - distance_m.abs() / SCORED_DISTANCE_M).max(0.0)
    })
}

/// The pose around a predicted one at which the beam ends have the highest sum of scores. `score` is 0 to 1 at a point; the
/// prior counts by its standard deviations, metres and radians. Ends are in the robot's frame.
pub(crate) fn coarse_search(
    ends: impl ExactSizeIterator<Item = Point>,
    prior: &Pose,
    (sigma_m, sigma_rad): (f64, f64),
    score: impl Fn(f64, f64) -> f64,
) -> Pose {
    let stride = ends.len().div_ceil(BEAMS).max(1);
    let ends: Vec<Point> = ends.step_by(stride).collect();
    let steps =
        |sigma: f64, step: f64, most: f64| ((SIGMAS * sigma).min(most) / step).ceil() as i32;
    let across = steps(sigma_m, STEP_M, MAX_EXTENT_M);
    let around = steps(sigma_rad, STEP_RAD, MAX_EXTENT_RAD);
    let mut rotated = Vec::with_capacity(ends.len());
    let (mut best, mut best_pose) = (f64::NEG_INFINITY, *prior);
    for turn in outwards(around) {
        let turned = STEP_RAD * f64::from(turn);
        let (sin, cos) = libm::sincos(prior.yaw + turned);
        rotated.clear();
        rotated.extend(
            ends.iter().map(|end| {
                (prior.x + cos * end.x - sin * end.y, prior.y + sin * end.x + cos * end.y)
            }),
        );
        let of_turn = (turned / sigma_rad) * (turned / sigma_rad);
        for row in outwards(across) {
            for column in outwards(across) {
                let (dx, dy) = (STEP_M * f64::from(column), STEP_M * f64::from(row));
                let far = (dx * dx + dy * dy) / (sigma_m * sigma_m) + of_turn;
                let mut total = -0.5 * far;
                // The highest total that the remaining beams allow.
                let mut bound = total + rotated.len() as f64;
                for (x, y) in &rotated {
                    if bound <= best {
                        break;
                    }
                    let score = score(x + dx, y + dy);
                    total += score;
                    bound -= 1.0 - score;
                }
                if bound > best && total > best {
                    best = total;
                    best_pose =
                        Pose::new(prior.x + dx, prior.y + dy, wrap_angle(prior.yaw + turned));
                }
            }
        }
    }
    best_pose
}

/// The numbers from zero outwards: 0, -1, 1, -2, 2 and so on. A good pose is found early, and most others are given up soon.
fn outwards(most: i32) -> impl Iterator<Item = i32> {
    core::iter::once(0).chain((1..=most).flat_map(|step| [-step, step]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn search_finds_a_corner_from_a_wrong_pose() {
        // Walls at x = 5 and y = 3.
        let score = |x: f64, y: f64| (1.0 - (x - 5.0).abs().min((y - 3.0).abs()) / 0.3).max(0.0);
        let truth = Pose::new(0.4, -0.2, 0.15);
        let walls = (0..40).map(|step| Point::new(5.0, -3.0 + 0.15 * f64::from(step)));
        let walls = walls.chain((0..40).map(|step| Point::new(-1.0 + 0.15 * f64::from(step), 3.0)));
        let ends: Vec<Point> = walls.map(|point| truth.inverse_transform(&point)).collect();
        let found = coarse_search(ends.into_iter(), &Pose::default(), (0.3, 0.1), score);
        assert!((found.position() - truth.position()).norm() < STEP_M, "{found:?}");
        assert!((found.yaw - truth.yaw).abs() <= STEP_RAD, "{found:?}");
    }
}
