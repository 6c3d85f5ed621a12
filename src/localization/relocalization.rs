//! Relocalisation: a search of the whole map for the one place at which a revolution matches it.
//!
//! The search covers the whole map, because a robot that was carried may be anywhere. A place near the last pose may agree with
//! most beams by chance; only the comparison with all other places excludes it. The search is spread over many revolutions, so
//! that each costs a bounded time. The robot stands meanwhile.

use core::f64::consts::TAU;

use nalgebra::{Matrix3, Vector3};

use super::scan_matcher::ScanMatcher;
use super::signed_distance_field::SignedDistanceField;
use super::{Agreement, DeskewedScan, LocalizationSettings};
use crate::geometry::{Pose, wrap_angle};

/// Spacing of the sampled poses: metres, and number of yaw angles.
const STEP_M: f64 = 0.2;
const YAWS: u32 = 60;

/// Beams used to score a sampled pose, evenly distributed over the revolution, and the number after which a poor pose is
/// given up.
const BEAMS: usize = 40;
const FIRST_BEAMS: usize = 10;

/// Share of the highest score that a sampled pose must have.
const MIN_SCORE: f64 = 0.3;

/// Beam ends up to this distance from a surface contribute to the score, metres.
const MAX_SCORED_DISTANCE_M: f64 = 0.3;

/// Number of best samples that are refined, and their smallest separation, metres and radians.
const REFINED: usize = 24;
const SEPARATION_M: f64 = 0.5;
const SEPARATION_RAD: f64 = 0.3;

/// Two places are distinct beyond this distance, metres and radians.
const DISTINCT_M: f64 = 1.0;
const DISTINCT_RAD: f64 = 0.5;

/// Standard deviation of a sampled pose, metres and radians.
const SIGMA_M: f64 = 0.2;
const SIGMA_RAD: f64 = 0.1;

/// Number of poses that are scored at each revolution: a few milliseconds.
const POSES_PER_STEP: usize = 60_000;

fn is_apart(one: &Pose, other: &Pose, distance_m: f64, angle_rad: f64) -> bool {
    (one.position() - other.position()).norm() > distance_m
        || wrap_angle(one.yaw - other.yaw).abs() > angle_rad
}

/// The result of a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Found {
    /// One place matches, and no other nearly as well: its pose in the grid's frame.
    Unique(Pose),
    /// Several places match about as well.
    Ambiguous,
    /// No place matches.
    Nothing,
}

/// A search for the pose of a standing robot, spread over its revolutions.
#[derive(Clone, Debug)]
pub(super) struct GlobalSearch {
    /// The revolution to be matched, and the odometry at its time.
    scan: DeskewedScan,
    pub odometry: Pose,
    /// Number of finished lines of samples: one for each yaw and row of samples.
    lines: u64,
    /// The best samples with their scores, separated from each other.
    best: Vec<(f64, Pose)>,
}

impl GlobalSearch {
    /// Starts a search for the place of a revolution.
    pub fn new(scan: &DeskewedScan, odometry: &Pose) -> Self {
        Self {
            scan: scan.clone(),
            odometry: *odometry,
            lines: 0,
            best: Vec::with_capacity(REFINED + 1),
        }
    }

    /// Continues the search; returns its result when the whole map was searched.
    pub fn step(
        &mut self,
        map: &SignedDistanceField,
        settings: &LocalizationSettings,
    ) -> Option<Found> {
        let frame = &map.frame;
        let samples = |cells: i32| (f64::from(cells) * frame.resolution_m / STEP_M).ceil() as u32;
        let (columns, rows) = (samples(frame.width), samples(frame.height));
        let lines = u64::from(YAWS) * u64::from(rows);
        let stride = self.scan.hits.len().div_ceil(BEAMS).max(1);
        let mut scored = 0;
        let mut ends = Vec::with_capacity(BEAMS);
        let mut rotated_to = None;
        while self.lines < lines && scored < POSES_PER_STEP {
            let turn = (self.lines / u64::from(rows)) as u32;
            let row = (self.lines % u64::from(rows)) as u32;
            let yaw = wrap_angle(TAU * f64::from(turn) / f64::from(YAWS));
            if rotated_to.replace(turn) != Some(turn) {
                let (sin, cos) = libm::sincos(yaw);
                ends.clear();
                ends.extend(self.scan.hits.iter().step_by(stride).map(|hit| {
                    let end = &hit.end;
                    (cos * end.x - sin * end.y, sin * end.x + cos * end.y)
                }));
            }
            for column in 0..columns {
                let at = |index: u32| STEP_M * (f64::from(index) + 0.5);
                let (x, y) = (at(column), at(row));
                // The robot stands in free space.
                if map.cell_distance_m(x, y).is_none_or(|distance_m| distance_m <= 0.0) {
                    continue;
                }
                scored += 1;
                if let Some(score) = score(map, &ends, x, y) {
                    self.keep(score, Pose::new(x, y, yaw));
                }
            }
            self.lines += 1;
        }
        (self.lines >= lines).then(|| self.conclude(map, settings))
    }

    /// Keeps a sample if it is one of the best, and better than its neighbours.
    fn keep(&mut self, score: f64, pose: Pose) {
        if self.best.len() == REFINED && self.best.last().is_some_and(|worst| worst.0 >= score) {
            return;
        }
        let is_near =
            |other: &(f64, Pose)| !is_apart(&other.1, &pose, SEPARATION_M, SEPARATION_RAD);
        if self.best.iter().any(|other| is_near(other) && other.0 >= score) {
            return;
        }
        self.best.retain(|other| !is_near(other));
        let index = self.best.partition_point(|other| other.0 >= score);
        self.best.insert(index, (score, pose));
        self.best.truncate(REFINED);
    }

    /// Refines the best samples, and compares the best place with all others.
    fn conclude(&self, map: &SignedDistanceField, settings: &LocalizationSettings) -> Found {
        let matcher = ScanMatcher { map, scan: &self.scan, settings };
        let sigmas = Vector3::new(SIGMA_M, SIGMA_M, SIGMA_RAD);
        let information = Matrix3::from_diagonal(&sigmas.map(|sigma| 1.0 / (sigma * sigma)));
        let refine = |(_, pose): &(f64, Pose)| {
            let pose = matcher.match_scan(pose, &information, 0.5 * SIGMA_M).pose;
            (matcher.agreement(&pose), pose)
        };
        let candidates: Vec<(Agreement, Pose)> = self.best.iter().map(refine).collect();
        // Ties go to the first, so that the result is deterministic.
        let best = candidates.iter().reduce(|best, other| {
            if other.0.matching_fraction() > best.0.matching_fraction() { other } else { best }
        });
        let Some((agreement, pose)) = best else {
            return Found::Nothing;
        };
        let is_good = agreement.matching_fraction() >= settings.relocalized_agreement
            && agreement.through_walls_fraction() <= settings.max_through_walls / 2.0;
        if !is_good {
            return Found::Nothing;
        }
        let second = candidates
            .iter()
            .filter(|(_, other)| is_apart(other, pose, DISTINCT_M, DISTINCT_RAD))
            .map(|(agreement, _)| agreement.matching_fraction())
            .fold(0.0, f64::max);
        if agreement.matching_fraction() >= second + settings.relocalization_margin {
            Found::Unique(*pose)
        } else {
            Found::Ambiguous
        }
    }
}

/// How near beam ends lie to surfaces of the map, for a robot at a point; none for a poor pose.
fn score(map: &SignedDistanceField, ends: &[(f64, f64)], x: f64, y: f64) -> Option<f64> {
    let of = |(along, up): &(f64, f64)| {
        let distance_m =
            map.cell_distance_m(x + along, y + up).map_or(MAX_SCORED_DISTANCE_M, f64::abs);
        (1.0 - distance_m / MAX_SCORED_DISTANCE_M).max(0.0)
    };
    // A few beams all around decide about most poses.
    let stride = ends.len().div_ceil(FIRST_BEAMS).max(1);
    let first: f64 = ends.iter().step_by(stride).map(of).sum();
    let firsts = ends.len().div_ceil(stride);
    if first < 0.5 * MIN_SCORE * firsts as f64 {
        return None;
    }
    let sum: f64 = ends.iter().map(of).sum();
    (sum >= MIN_SCORE * ends.len() as f64).then_some(sum)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{GridFrame, ObstacleGrid};

    /// 71,582,789 rows of samples: 60 times that is 44 more than the range of 32 bits.
    #[test]
    fn very_high_map_is_searched_to_its_end() {
        let frame = GridFrame::new(1, 32_767, 436.92, Pose::default()).expect("a valid size");
        let map = SignedDistanceField::new(&ObstacleGrid::new(frame, vec![false; frame.len()]));
        let settings = LocalizationSettings::default();
        let mut search = GlobalSearch::new(&DeskewedScan::default(), &Pose::default());
        for _ in 0..4 {
            assert_eq!(search.step(&map, &settings), None);
        }
    }
}
