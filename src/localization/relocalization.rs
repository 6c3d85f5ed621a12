//! Relocalisation: a search of the whole map for the one place at which a revolution matches it.
//!
//! The search covers the whole map, because a robot that was carried may be anywhere. A place near the last pose may agree with
//! most beams by chance; only the comparison with all other places excludes it.
//!
//! Branch and bound: nodes are blocks of translations at one yaw, with a bound of the scores in them. The node with the highest bound
//! is divided first, so poses come in the order of their scores, and the search ends when no other place can be nearly as good as
//! the best one. It is spread over revolutions, so that each costs a bounded time. The robot stands meanwhile.

use core::cmp::Reverse;
use core::f64::consts::TAU;
use std::collections::BinaryHeap;

use super::map_scores::{FULL, MapScores};
use super::scan_matcher::{ScanMatcher, information_of};
use super::signed_distance_field::SignedDistanceField;
use super::{Agreement, DeskewedScan, LocalizationSettings};
use crate::geometry::{Point, Pose, wrap_angle};

/// Beams that are scored, evenly distributed over the revolution.
const BEAMS: usize = 60;

/// A step of the yaw moves the end of a long beam by this, metres; the beam is longer than most. The smallest and the largest step.
const STEP_M: f64 = 0.3;
const LONG_BEAM_SHARE: f64 = 0.8;
const STEP_RAD: (f64, f64) = (0.02, 0.1);

/// Share of the highest score that a pose must have, and by how much less than the best pose.
const MIN_SCORE: f64 = 0.3;
const SCORE_MARGIN: f64 = 0.25;

/// Number of best poses that are refined, and their smallest separation, metres and radians.
const REFINED: usize = 24;
const SEPARATION_M: f64 = 0.5;
const SEPARATION_RAD: f64 = 0.3;
/// If all of them score as the best one but for this share of the highest score, no place is unique.
const SAME_SCORE: f64 = 0.08;

/// Two places are distinct beyond this distance, metres and radians.
const DISTINCT_M: f64 = 1.0;
const DISTINCT_RAD: f64 = 0.5;

/// Standard deviation of a found pose, metres and radians.
const SIGMA_M: f64 = 0.2;
const SIGMA_RAD: f64 = 0.1;

/// Largest number of nodes that are bounded.
const MAX_NODES: usize = 20_000_000;

fn is_apart(one: &Pose, other: &Pose, distance_m: f64, angle_rad: f64) -> bool {
    (one.position() - other.position()).norm() > distance_m
        || wrap_angle(one.yaw - other.yaw).abs() > angle_rad
}

/// The result of a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Found {
    /// One place matches, and no other nearly as well: its pose in the grid's frame.
    Unique(Pose),
    /// Several places match about as well: the best one, unless there were too many to compare.
    Ambiguous(Option<Pose>),
    /// No place matches.
    Nothing,
}

/// The poses among which a search looks, in the grid's frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct SearchRegion {
    pub center: Pose,
    pub radius_m: f64,
    pub half_angle_rad: f64,
}

impl SearchRegion {
    /// Whether it has a pose with a yaw in a square with this lower left corner and side, metres.
    fn overlaps(&self, yaw: f64, corner: Point, side_m: f64) -> bool {
        let center = self.center.position();
        let nearest = Point::new(
            center.x.clamp(corner.x, corner.x + side_m),
            center.y.clamp(corner.y, corner.y + side_m),
        );
        wrap_angle(yaw - self.center.yaw).abs() <= self.half_angle_rad
            && (nearest - center).norm() <= self.radius_m
    }
}

/// A block of translations at one yaw, the highest bound first; of equal bounds the smallest block, and then in a fixed order.
type Node = (u32, Reverse<u8>, Reverse<[i32; 3]>);

/// A search for the pose of a robot at one revolution, spread over its revolutions.
#[derive(Clone, Debug)]
pub(super) struct GlobalSearch {
    /// The revolution to be matched, and the odometry at its time.
    scan: DeskewedScan,
    pub odometry: Pose,
    /// `None` for the whole map.
    region: Option<SearchRegion>,
    /// Cells of the beam ends relative to the robot, for each yaw.
    turns: Vec<Vec<(i32, i32)>>,
    /// Number of finished blocks of the largest size.
    roots: usize,
    nodes: BinaryHeap<Node>,
    bounded: usize,
    /// The best poses with their scores, separated from each other, the best first.
    best: Vec<(u32, Pose)>,
}

impl GlobalSearch {
    /// Starts a search for the place of a revolution on the whole map.
    pub fn new(scan: &DeskewedScan, odometry: &Pose, map: &MapScores) -> Self {
        let stride = scan.hits.len().div_ceil(BEAMS).max(1);
        let ends: Vec<_> = scan.hits.iter().step_by(stride).map(|hit| hit.end).collect();
        let mut lengths: Vec<f64> = ends.iter().map(|end| end.to_vector().norm()).collect();
        lengths.sort_by(f64::total_cmp);
        let long = lengths.get((LONG_BEAM_SHARE * lengths.len() as f64) as usize);
        let step_rad = (STEP_M / long.copied().unwrap_or(1.0)).clamp(STEP_RAD.0, STEP_RAD.1);
        let count = (TAU / step_rad).ceil();
        let cells = |turn: u32| {
            let (sin, cos) = libm::sincos(TAU * f64::from(turn) / count);
            // The robot stands in the middle of a cell.
            let cell = |along: f64| (along / map.cell_m + 0.5).floor() as i32;
            let turned = |x: f64, y: f64| (cell(cos * x - sin * y), cell(sin * x + cos * y));
            ends.iter().map(|end| turned(end.x, end.y)).collect()
        };
        Self {
            scan: scan.clone(),
            odometry: *odometry,
            region: None,
            turns: (0..count as u32).map(cells).collect(),
            roots: 0,
            nodes: BinaryHeap::new(),
            bounded: 0,
            best: Vec::with_capacity(REFINED),
        }
    }

    /// The search restricted to a region, before its first step.
    pub fn within(self, region: SearchRegion) -> Self {
        Self { region: Some(region), ..self }
    }

    /// Whether the search is restricted to a region.
    pub const fn is_restricted(&self) -> bool {
        self.region.is_some()
    }

    /// Continues the search by a number of nodes; returns its result when all of the map or region was searched.
    pub fn step(
        &mut self,
        map: &SignedDistanceField,
        scores: &MapScores,
        settings: &LocalizationSettings,
        nodes: usize,
    ) -> Option<Found> {
        let until = self.bounded + nodes;
        self.bound_largest(scores, until);
        while self.bounded < until {
            let Some((bound, Reverse(level), Reverse([turn, right, up]))) = self.nodes.pop() else {
                return Some(self.conclude(map, settings));
            };
            if bound < self.least() || self.best.len() == REFINED {
                self.nodes.clear();
                return Some(self.conclude(map, settings));
            }
            if level == 0 {
                self.keep(bound, self.pose(scores, [turn, right, up]));
                continue;
            }
            let half = 1 << (level - 1);
            for (x, y) in [(0, 0), (half, 0), (0, half), (half, half)] {
                self.bound(scores, level - 1, [turn, right + x, up + y]);
            }
        }
        (self.bounded > MAX_NODES).then_some(Found::Ambiguous(None))
    }

    /// Whether the revolution agrees much better with the map at a pose than at the believed one, and the two are distinct.
    pub fn is_better(
        &self,
        map: &SignedDistanceField,
        settings: &LocalizationSettings,
        pose: &Pose,
        believed: &Pose,
    ) -> bool {
        let matcher = ScanMatcher { map, scan: &self.scan, settings };
        let share = |pose: &Pose| matcher.agreement(pose).matching_fraction();
        is_apart(pose, believed, DISTINCT_M, DISTINCT_RAD)
            && share(pose) >= share(believed) + settings.relocalization_margin
    }

    /// Bounds the blocks of the largest size, up to a number of nodes.
    fn bound_largest(&mut self, scores: &MapScores, until: usize) {
        let top = scores.scores.top();
        let side = 1_usize << top;
        let columns = (scores.scores.columns() as usize).div_ceil(side);
        let blocks = columns * (scores.scores.rows() as usize).div_ceil(side);
        let all = blocks * self.turns.len();
        while self.roots < all && self.bounded < until {
            let (turn, block) = (self.roots / blocks, self.roots % blocks);
            let (right, up) = (block % columns * side, block / columns * side);
            self.bound(scores, top as u8, [turn as i32, right as i32, up as i32]);
            self.roots += 1;
        }
    }

    /// Adds a node if a pose in it can be good enough.
    fn bound(&mut self, scores: &MapScores, level: u8, node: [i32; 3]) {
        let [turn, right, up] = node;
        let at = usize::from(level);
        let is_outside = |region: &SearchRegion| {
            let corner = |cell: i32| scores.cell_m * f64::from(cell);
            let side_m = scores.cell_m * f64::from(1 << level);
            !region.overlaps(self.yaw(turn), Point::new(corner(right), corner(up)), side_m)
        };
        if self.region.as_ref().is_some_and(is_outside) {
            return;
        }
        // The robot stands in free space.
        if scores.free.sum_of(at, &[(0, 0)], right, up) == 0 {
            return;
        }
        self.bounded += 1;
        let bound = scores.scores.sum_of(at, &self.turns[turn as usize], right, up);
        if bound >= self.least() {
            self.nodes.push((bound, Reverse(level), Reverse(node)));
        }
    }

    /// The smallest score that a pose must have.
    fn least(&self) -> u32 {
        let best = self.best.first().map_or(0, |best| best.0);
        let near = best.saturating_sub(self.of_full(SCORE_MARGIN));
        near.max(self.of_full(MIN_SCORE)).max(1)
    }

    /// A share of the highest score.
    fn of_full(&self, share: f64) -> u32 {
        let beams = self.turns.first().map_or(0, Vec::len);
        (share * (f64::from(FULL) * beams as f64)) as u32
    }

    fn pose(&self, scores: &MapScores, [turn, right, up]: [i32; 3]) -> Pose {
        let at = |cell: i32| scores.cell_m * (f64::from(cell) + 0.5);
        Pose::new(at(right), at(up), self.yaw(turn))
    }

    fn yaw(&self, turn: i32) -> f64 {
        wrap_angle(TAU * f64::from(turn) / self.turns.len() as f64)
    }

    /// Keeps a pose unless it is near a better one: they come in the order of their scores.
    fn keep(&mut self, score: u32, pose: Pose) {
        let is_near =
            |other: &(u32, Pose)| !is_apart(&other.1, &pose, SEPARATION_M, SEPARATION_RAD);
        if !self.best.iter().any(is_near) {
            self.best.push((score, pose));
        }
    }

    /// Refines the best poses, and compares the best place with all others.
    fn conclude(&self, map: &SignedDistanceField, settings: &LocalizationSettings) -> Found {
        let matcher = ScanMatcher { map, scan: &self.scan, settings };
        let information = information_of(SIGMA_M, SIGMA_RAD);
        let refine = |(_, pose): &(u32, Pose)| {
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
        let is_cut = self.best.len() == REFINED
            && self.best[REFINED - 1].0 + self.of_full(SAME_SCORE) > self.best[0].0;
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
        if !is_cut && agreement.matching_fraction() >= second + settings.relocalization_margin {
            Found::Unique(*pose)
        } else {
            Found::Ambiguous(Some(*pose))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{GridFrame, ObstacleGrid};

    /// A map without surfaces, 14 million kilometres high: its cells are few and large.
    #[test]
    fn very_high_map_is_searched_to_its_end() {
        let frame = GridFrame::new(1, 32_767, 436.92, Pose::default()).expect("a valid size");
        let map = SignedDistanceField::new(&ObstacleGrid::new(frame, vec![false; frame.len()]));
        let (scores, settings) = (MapScores::new(&map), LocalizationSettings::default());
        let mut search = GlobalSearch::new(&DeskewedScan::default(), &Pose::default(), &scores);
        let found = (0..20).find_map(|_| search.step(&map, &scores, &settings, 150_000));
        assert_eq!(found, Some(Found::Nothing));
    }
}
