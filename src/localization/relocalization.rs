//! Relocalisation: a search of the whole map for the one place at which a revolution matches it.
//!
//! The search covers the whole map, because a robot that was carried may be anywhere. A place near the last pose may agree with
//! most beams by chance; only the comparison with all other places excludes it.
//!
//! Branch and bound: nodes are blocks of translations at one yaw, with a bound of the scores in them. The node with the highest bound
//! is divided first, so poses come in the order of their scores, and the search ends when no other place can be nearly as good as
//! the best one. It is spread over revolutions, so that each costs a bounded time. The robot stands meanwhile.

use core::f64::consts::TAU;

use super::frontier::{Frontier, Node};
use super::map_scores::{FULL, MapScores};
use super::scan_matcher::{ScanMatcher, information_of};
use super::score_pyramid::EndCells;
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

/// The cells of points relative to that of the robot, which stands in the middle of its cell, at a yaw.
fn turned_cells(points: &[Point], yaw: f64, cell_m: f64) -> Vec<(i32, i32)> {
    let (sin, cos) = libm::sincos(yaw);
    let cell = |along: f64| (along / cell_m + 0.5).floor() as i32;
    let turned =
        |point: &Point| (cell(cos * point.x - sin * point.y), cell(sin * point.x + cos * point.y));
    points.iter().map(turned).collect()
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

/// A search for the pose of a robot at one revolution, spread over its revolutions.
#[derive(Clone, Debug)]
pub(super) struct GlobalSearch {
    /// The revolution to be matched, and the odometry at its time.
    scan: DeskewedScan,
    pub odometry: Pose,
    /// `None` for the whole map.
    region: Option<SearchRegion>,
    /// Cells of the beam ends relative to the robot, for each yaw.
    turns: Vec<EndCells>,
    /// Highest score of a pose.
    full: u32,
    /// Number of finished groups of four of the largest nodes.
    roots: usize,
    frontier: Frontier,
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
        let turned = |turn: u32| {
            let cells = turned_cells(&ends, TAU * f64::from(turn) / count, map.cell_m);
            EndCells::new(&cells)
        };
        let full = u32::from(FULL) * ends.len() as u32;
        Self {
            scan: scan.clone(),
            odometry: *odometry,
            region: None,
            turns: (0..count as u32).map(turned).collect(),
            full,
            roots: 0,
            frontier: Frontier::new(full),
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
            let Some((bound, node)) = self.frontier.pop() else {
                return Some(self.conclude(map, settings));
            };
            if bound < self.least() || self.best.len() == REFINED {
                self.frontier.clear();
                return Some(self.conclude(map, settings));
            }
            if node.level == 0 {
                self.keep(bound, self.pose(scores, &node));
            } else {
                self.divide(scores, node);
            }
        }
        (self.bounded > MAX_NODES).then_some(Found::Ambiguous(None))
    }

    /// By which share more of the revolution agrees with the map at a pose than at the believed one; `None` where both are one place.
    pub fn gain_over(
        &self,
        map: &SignedDistanceField,
        settings: &LocalizationSettings,
        pose: &Pose,
        believed: &Pose,
    ) -> Option<f64> {
        let matcher = ScanMatcher { map, scan: &self.scan, settings };
        let share = |pose: &Pose| matcher.agreement(pose).matching_fraction();
        is_apart(pose, believed, DISTINCT_M, DISTINCT_RAD).then(|| share(pose) - share(believed))
    }

    /// Bounds the largest nodes, up to a number of nodes.
    fn bound_largest(&mut self, scores: &MapScores, until: usize) {
        let level = scores.scores.top() + 1;
        let groups = |cells: i32| (cells as usize).div_ceil(1 << level);
        let (columns, rows) = (groups(scores.scores.columns()), groups(scores.scores.rows()));
        let all = columns * rows * self.turns.len();
        while self.roots < all && self.bounded < until {
            let (turn, group) = (self.roots / (columns * rows), self.roots % (columns * rows));
            let at = |group: usize| (group << level) as u16;
            let (right, up) = (at(group % columns), at(group / columns));
            self.divide(scores, Node { level: level as u8, turn: turn as u16, right, up });
            self.roots += 1;
        }
    }

    /// Adds the quarters of a node in which a pose can be good enough.
    fn divide(&mut self, scores: &MapScores, node: Node) {
        let level = node.level - 1;
        let quarters = [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(right, up)| Node {
            level,
            right: node.right + (right << level),
            up: node.up + (up << level),
            ..node
        });
        let (right, up) = (i32::from(node.right), i32::from(node.up));
        // The robot stands in free space.
        let mut is_possible = scores.free.of_four(usize::from(level), right, up);
        for (is_possible, quarter) in is_possible.iter_mut().zip(&quarters) {
            *is_possible &= self.is_searched(scores, quarter);
        }
        if is_possible == [false; 4] {
            return;
        }
        let ends = &self.turns[usize::from(node.turn)];
        let bounds = scores.scores.sums_of_four(usize::from(level), ends, right, up);
        for ((quarter, bound), is_possible) in quarters.into_iter().zip(bounds).zip(is_possible) {
            if is_possible {
                self.bounded += 1;
                if bound >= self.least() {
                    self.frontier.push(bound, quarter);
                }
            }
        }
    }

    /// Whether the region has a pose of a node.
    fn is_searched(&self, scores: &MapScores, node: &Node) -> bool {
        self.region.as_ref().is_none_or(|region| {
            let corner = |cell: u16| scores.cell_m * f64::from(cell);
            let side_m = scores.cell_m * f64::from(1 << node.level);
            region.overlaps(
                self.yaw(node.turn),
                Point::new(corner(node.right), corner(node.up)),
                side_m,
            )
        })
    }

    /// The smallest score that a pose must have.
    fn least(&self) -> u32 {
        let best = self.best.first().map_or(0, |best| best.0);
        let near = best.saturating_sub(self.of_full(SCORE_MARGIN));
        near.max(self.of_full(MIN_SCORE)).max(1)
    }

    /// A share of the highest score.
    fn of_full(&self, share: f64) -> u32 {
        (share * f64::from(self.full)) as u32
    }

    /// The pose of a node with one translation.
    fn pose(&self, scores: &MapScores, node: &Node) -> Pose {
        let at = |cell: u16| scores.cell_m * (f64::from(cell) + 0.5);
        Pose::new(at(node.right), at(node.up), self.yaw(node.turn))
    }

    fn yaw(&self, turn: u16) -> f64 {
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
            if other.0.matching_of_all() > best.0.matching_of_all() { other } else { best }
        });
        let Some((agreement, pose)) = best else {
            return Found::Nothing;
        };
        let is_cut = self.best.len() == REFINED
            && self.best[REFINED - 1].0 + self.of_full(SAME_SCORE) > self.best[0].0;
        let is_good = agreement.matching_of_all() >= settings.relocalized_agreement
            && agreement.through_walls_fraction() <= settings.max_through_walls / 2.0;
        if !is_good {
            return Found::Nothing;
        }
        let second = candidates
            .iter()
            .filter(|(_, other)| is_apart(other, pose, DISTINCT_M, DISTINCT_RAD))
            .map(|(agreement, _)| agreement.matching_of_all())
            .fold(0.0, f64::max);
        if !is_cut && agreement.matching_of_all() >= second + settings.relocalization_margin {
            Found::Unique(*pose)
        } else {
            Found::Ambiguous(Some(*pose))
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    use super::*;
    use crate::geometry::Vector;
    use crate::localization::Hit;
    use crate::map::{Cell, GridFrame, ObstacleGrid, RayCaster, RayEnd};

    const COLUMNS: i32 = 90;
    const ROWS: i32 = 75;
    const BEAMS_SEEN: u32 = 50;

    /// A map, and what a robot on it sees.
    struct Case {
        map: SignedDistanceField,
        scores: MapScores,
        ends: Vec<Point>,
    }

    impl Case {
        /// Random blocks; the right half of the map may be as the left one.
        fn new(random: &mut Pcg64Mcg, is_doubled: bool) -> Self {
            let frame = GridFrame::new(COLUMNS, ROWS, 0.1, Pose::default()).expect("a valid size");
            let width = if is_doubled { COLUMNS / 2 } else { COLUMNS };
            let mut cells = vec![false; frame.len()];
            for _ in 0..12 {
                let (left, low) = (random.random_range(0..width), random.random_range(0..ROWS));
                let (right, high) =
                    (left + random.random_range(1..20), low + random.random_range(1..12));
                for row in low..high.min(ROWS) {
                    for column in (0..COLUMNS).filter(|it| (left..right).contains(&(it % width))) {
                        cells[frame.index(Cell { column, row })] = true;
                    }
                }
            }
            let obstacles = ObstacleGrid::new(frame, cells);
            let free = loop {
                let cell = frame.cell_at(random.random_range(0..frame.len()));
                if !obstacles.is_blocked(cell) {
                    break frame.center_of(cell);
                }
            };
            let (caster, yaw) = (RayCaster::new(&obstacles), random.random_range(0.0..TAU));
            let mut ends = Vec::new();
            for beam in 0..BEAMS_SEEN {
                let angle = TAU * f64::from(beam) / f64::from(BEAMS_SEEN);
                let (sin, cos) = libm::sincos(angle);
                if let RayEnd::Blocked(range_m) = caster.cast(&free, yaw + angle, 6.0) {
                    ends.push(Point::default() + Vector::new(cos, sin) * range_m);
                }
            }
            let map = SignedDistanceField::new(&obstacles);
            let scores = MapScores::new(&map);
            Self { map, scores, ends }
        }

        /// A finished search, in steps of this number of nodes.
        fn search(&self, nodes: usize) -> GlobalSearch {
            let hit = |end: &Point| Hit { from: Point::default(), end: *end, is_alone: false };
            let hits = self.ends.iter().map(hit).collect();
            let scan = DeskewedScan { hits, range_max: 6.0, ..DeskewedScan::default() };
            let mut search = GlobalSearch::new(&scan, &Pose::default(), &self.scores);
            let settings = LocalizationSettings::default();
            while search.step(&self.map, &self.scores, &settings, nodes).is_none() {}
            search
        }

        /// The score of each pose at which a robot can stand, in the order of turn, row and column.
        fn all_poses(&self, search: &GlobalSearch) -> Vec<(u32, Pose)> {
            let turns = search.turns.len() as u16;
            let mut all = Vec::new();
            for turn in 0..turns {
                let yaw = TAU * f64::from(turn) / f64::from(turns);
                let cells = turned_cells(&self.ends, yaw, self.scores.cell_m);
                for (up, right) in (0..ROWS).flat_map(|up| (0..COLUMNS).map(move |it| (up, it))) {
                    let node = Node { level: 0, turn, right: right as u16, up: up as u16 };
                    let pose = search.pose(&self.scores, &node);
                    if self.map.cell_distance_m(pose.x, pose.y).is_some_and(|it| it > 0.0) {
                        let score = |(column, row): &(i32, i32)| {
                            u32::from(self.scores.scores.score(column + right, row + up))
                        };
                        all.push((cells.iter().map(score).sum(), pose));
                    }
                }
            }
            all
        }
    }

    /// Compares the best poses of a finished search with all poses of the map.
    fn compare(search: &GlobalSearch, all: &[(u32, Pose)]) -> Result<(), String> {
        let best = &search.best;
        let highest = all.iter().map(|(score, _)| *score).max().filter(|it| *it >= search.least());
        if best.first().map(|(score, _)| *score) != highest {
            return Err(format!(
                "{highest:?} is the highest score, not that of {:?}",
                best.first()
            ));
        }
        let is_near =
            |one: &Pose, other: &Pose| !is_apart(one, other, SEPARATION_M, SEPARATION_RAD);
        for (index, found) in best.iter().enumerate() {
            let is_in_order = best[..index]
                .iter()
                .all(|(score, pose)| *score >= found.0 && !is_near(pose, &found.1));
            if found.0 < search.least() || !is_in_order || !all.contains(found) {
                return Err(format!("{found:?} is no pose that comes here"));
            }
        }
        // The search ends at the last pose that it keeps.
        let ends_at = best.get(REFINED - 1).map_or(search.least(), |(score, _)| score + 1);
        let is_missed = |(score, pose): &&(u32, Pose)| {
            *score >= ends_at && !best.iter().any(|it| it.0 >= *score && is_near(&it.1, pose))
        };
        match all.iter().find(is_missed) {
            Some(missed) => Err(format!("{missed:?} was not found")),
            None => Ok(()),
        }
    }

    #[test]
    fn search_finds_the_best_of_all_poses_whatever_its_steps() {
        let mut random = Pcg64Mcg::seed_from_u64(21);
        for is_doubled in [false, true, false, true] {
            let case = Case::new(&mut random, is_doubled);
            let search = case.search(1_000_000);
            assert_eq!(compare(&search, &case.all_poses(&search)), Ok(()));
            assert!(search.best.len() > usize::from(is_doubled));
            assert_eq!(search.best, case.search(97).best);
        }
    }

    #[test]
    fn one_wrong_bit_of_a_score_is_found() {
        let mut random = Pcg64Mcg::seed_from_u64(22);
        let mut case = Case::new(&mut random, false);
        let search = case.search(1_000_000);
        let all = case.all_poses(&search);
        let (_, best) = search.best[0];
        let cells = turned_cells(&case.ends, best.yaw, case.scores.cell_m);
        let at = |along: f64| (along / case.scores.cell_m) as i32;
        let (right, up) = (at(best.x), at(best.y));
        case.scores.scores.flip_bit(cells[0].0 + right, cells[0].1 + up);
        assert_ne!(compare(&case.search(1_000_000), &all), Ok(()));
    }

    /// A map without surfaces, 14,000 km high: its cells are few and large.
    #[test]
    fn very_high_map_is_searched_to_its_end() {
        let (width, height, origin) = (1, 32_767, Pose::default());
        let frame = GridFrame { width, height, resolution_m: 436.92, origin };
        let map = SignedDistanceField::new(&ObstacleGrid::filled(frame, false));
        let (scores, settings) = (MapScores::new(&map), LocalizationSettings::default());
        let mut search = GlobalSearch::new(&DeskewedScan::default(), &Pose::default(), &scores);
        let found = (0..20).find_map(|_| search.step(&map, &scores, &settings, 150_000));
        assert_eq!(found, Some(Found::Nothing));
    }
}
