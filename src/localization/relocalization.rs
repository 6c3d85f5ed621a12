//! Relocalisation: a search for the pose near the last one at which a revolution matches the map.

use core::f64::consts::TAU;

use nalgebra::{Matrix3, Vector3};

use super::Agreement;
use super::scan_matcher::ScanMatcher;
use crate::geometry::{Pose, wrap_angle};

/// Spacing of the sampled poses: metres, and number of yaw angles.
const STEP_M: f64 = 0.2;
const YAWS: u32 = 48;

/// Beams used to score a sampled pose, evenly distributed over the revolution.
const BEAMS: usize = 40;

/// Beam ends up to this distance from a surface contribute to the score, metres.
const MAX_SCORED_DISTANCE_M: f64 = 0.3;

/// Number of best samples that are refined, and their smallest separation, metres and radians.
const REFINED: usize = 8;
const SEPARATION_M: f64 = 0.5;
const SEPARATION_RAD: f64 = 0.3;

/// Standard deviation of a sampled pose, metres and radians.
const SIGMA_M: f64 = 0.2;
const SIGMA_RAD: f64 = 0.1;

/// The best candidate must agree in this larger a fraction of the beams than any other.
const MIN_LEAD: f64 = 0.1;

fn is_separate(one: &Pose, other: &Pose) -> bool {
    (one.position() - other.position()).norm() > SEPARATION_M
        || wrap_angle(one.yaw - other.yaw).abs() > SEPARATION_RAD
}

impl ScanMatcher<'_> {
    /// The single pose near `center` in the grid's frame at which the scan agrees with the map sufficiently; none if there is
    /// no such pose, or more than one.
    pub fn relocalize(&self, center: &Pose) -> Option<Pose> {
        let sigmas = Vector3::new(SIGMA_M, SIGMA_M, SIGMA_RAD);
        let information = Matrix3::from_diagonal(&sigmas.map(|sigma| 1.0 / (sigma * sigma)));
        let refined = self.best_samples(center).into_iter().map(|pose| {
            let pose = self.match_scan(&pose, &information, 0.5 * SIGMA_M).pose;
            (self.agreement(&pose), pose)
        });
        let candidates: Vec<(Agreement, Pose)> = refined.collect();
        // Ties go to the first, so that the result is deterministic.
        let (agreement, pose) = candidates.iter().reduce(|best, other| {
            if other.0.matching_fraction() > best.0.matching_fraction() { other } else { best }
        })?;
        let second = candidates
            .iter()
            .filter(|(_, other)| is_separate(other, pose))
            .map(|(agreement, _)| agreement.matching_fraction())
            .fold(0.0, f64::max);
        let settings = self.settings;
        let is_good = agreement.matching_fraction() >= settings.relocalized_agreement
            && agreement.through_walls_fraction() <= settings.max_through_walls / 2.0
            && agreement.matching_fraction() >= second + MIN_LEAD;
        is_good.then_some(*pose)
    }

    /// The best poses of a regular grid of samples, separated from each other, best first; ties in sampling order.
    fn best_samples(&self, center: &Pose) -> Vec<Pose> {
        let hits = &self.scan.hits;
        let stride = hits.len().div_ceil(BEAMS).max(1);
        let steps = (self.settings.relocalization_radius_m / STEP_M).floor() as i32;
        let mut samples: Vec<(f64, Pose)> = Vec::new();
        let mut ends = Vec::with_capacity(BEAMS);
        for turn in 0..YAWS {
            let yaw = wrap_angle(center.yaw + TAU * f64::from(turn) / f64::from(YAWS));
            let (sin, cos) = libm::sincos(yaw);
            ends.clear();
            ends.extend(hits.iter().step_by(stride).map(|hit| {
                let end = &hit.end;
                (cos * end.x - sin * end.y, sin * end.x + cos * end.y)
            }));
            for row in -steps..=steps {
                for column in -steps..=steps {
                    if column * column + row * row > steps * steps {
                        continue;
                    }
                    let (x, y) =
                        (center.x + STEP_M * f64::from(column), center.y + STEP_M * f64::from(row));
                    // The robot stands in free space.
                    if self.map.cell_distance_m(x, y).is_none_or(|distance_m| distance_m <= 0.0) {
                        continue;
                    }
                    let score = |(along, up): &(f64, f64)| {
                        let distance_m = self
                            .map
                            .cell_distance_m(x + along, y + up)
                            .map_or(MAX_SCORED_DISTANCE_M, f64::abs);
                        (1.0 - distance_m / MAX_SCORED_DISTANCE_M).max(0.0)
                    };
                    let sum: f64 = ends.iter().map(score).sum();
                    if sum >= 0.3 * ends.len() as f64 {
                        samples.push((sum, Pose::new(x, y, yaw)));
                    }
                }
            }
        }
        // A stable sort keeps ties in sampling order.
        samples.sort_by(|one, other| other.0.total_cmp(&one.0));
        let mut best: Vec<Pose> = Vec::with_capacity(REFINED);
        for (_, pose) in &samples {
            if best.iter().all(|other| is_separate(other, pose)) {
                best.push(*pose);
                if best.len() == REFINED {
                    break;
                }
            }
        }
        best
    }
}
