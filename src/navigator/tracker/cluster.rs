//! Clusters: consecutive returns of one object, and the disc that fits them.

use core::ops::Range;

use nalgebra::Matrix2;

use super::super::scan_visibility::{Earlier, is_full_turn};
use super::filter::Fit;
use crate::geometry::{Point, Pose, Vector};
use crate::map::{Scan, object_runs};

/// A track that owns a return.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Owner {
    /// Index of the track.
    pub track: usize,
    pub is_moving: bool,
}

/// A return that the map does not explain.
#[derive(Clone, Copy, Debug)]
pub(super) struct Return {
    pub beam: usize,
    pub range_m: f64,
    pub point: Point,
    /// Whether it may belong to a new or moving object.
    pub is_candidate: bool,
    /// The track on whose expected disc it falls.
    pub owner: Option<Owner>,
    /// What earlier scans show of the place of a candidate.
    pub earlier: Earlier,
    /// Whether it belongs to a person who stands.
    pub is_of_standing: bool,
}

#[cfg(test)]
impl Return {
    /// A return from ground that was free, 1 m away, which may belong to a new object.
    pub const fn candidate(point: Point) -> Self {
        Self {
            beam: 0,
            range_m: 1.0,
            point,
            is_candidate: true,
            owner: None,
            earlier: Earlier::Free,
            is_of_standing: false,
        }
    }
}

/// Consecutive returns of one object.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cluster {
    /// Index of the first return; the cluster may continue at the beginning of the list.
    pub first: usize,
    /// Number of returns.
    pub count: usize,
    /// Shortest range, metres.
    pub near_m: f64,
    /// Direction of its right edge in the map frame, radians: half a beam before the first return.
    pub right: f64,
    /// Angle from there to its left edge, radians.
    pub spread: f64,
    /// Whether its right and left edges are its own: the beams next to them go beyond it.
    pub own_edges: [bool; 2],
    /// Whether it is connected to settled marks at its right and at its left.
    pub joins: [bool; 2],
    /// Distance from the first return to the last, metres.
    pub length_m: f64,
}

/// An object whose neighbouring beams on both sides go beyond it.
#[derive(Clone, Copy, Debug)]
pub(super) struct NarrowObject {
    /// Its middle return.
    pub middle: Point,
    /// Its centre, if it is as deep as wide.
    pub center: Point,
    /// Range of that return, metres.
    pub range_m: f64,
    /// Distance from its first return to its last, metres.
    pub width_m: f64,
    /// Number of returns.
    pub count: usize,
}

/// Returns of neighbouring beams belong together within this distance, metres, plus this many beam spacings. Two people who
/// pass each other are 0.1 m apart, and a person and the wall behind are farther apart.
const NEAR_M: f64 = 0.1;
const NEAR_SPACINGS: f64 = 2.0;
/// At most this many beams without a measurement may lie within a cluster.
const MAX_MISSING: usize = 3;
/// A beam goes beyond an edge if it is this much longer than the one on the edge, metres.
const BEYOND_EDGE_M: f64 = 0.05;
/// A longer cluster is no disc with a radius of at most 0.7 m, metres.
pub(super) const LONGEST_M: f64 = 1.5;

/// The returns of a scan from a pose.
#[derive(Clone, Copy)]
pub(super) struct ScanReturns<'a> {
    pub pose: &'a Pose,
    pub scan: &'a Scan,
    /// In the order of the beams.
    pub returns: &'a [Return],
}

impl ScanReturns<'_> {
    /// Finds the clusters. A cluster that is too long for a disc is split where the expected disc of a moving object ends.
    pub fn find_clusters(&self, found: &mut Vec<Cluster>) {
        found.clear();
        let are_candidates =
            |index: usize| self.at(index).is_candidate && self.at(index + 1).is_candidate;
        let runs = self.runs(|index| are_candidates(index) && self.belongs_to_next(index));
        for run in runs.filter(|run| self.at(run.start).is_candidate) {
            let whole = self.cluster(run.start, run.len());
            if whole.length_m <= LONGEST_M {
                found.push(whole);
                continue;
            }
            let owner = |step: usize| self.at(run.start + step).owner;
            let mut from = 0;
            for step in 1..=run.len() {
                if step == run.len() || owner(step) != owner(from) {
                    let first = (run.start + from) % self.returns.len();
                    found.push(self.cluster(first, step - from));
                    from = step;
                }
            }
        }
    }

    /// The objects that stand alone and are at most this wide, metres; settled marks too.
    pub fn narrow_objects(&self, widest_m: f64) -> Vec<NarrowObject> {
        let narrow = |run: Range<usize>| {
            let (right, left) = (self.at(run.start), self.at(run.end - 1));
            let is_alone = is_edge(self.scan, right, false) && is_edge(self.scan, left, true);
            let width_m = (left.point - right.point).norm();
            (is_alone && width_m <= widest_m).then(|| {
                let count = run.len();
                let &Return { point: middle, range_m, .. } = self.at(run.start + count / 2);
                let lidar = self.pose.transform(&self.scan.origin);
                let away = (middle - lidar) / range_m;
                let center = middle + away * (width_m / 2.0);
                NarrowObject { middle, center, range_m, width_m, count }
            })
        };
        self.runs(|index| self.belongs_to_next(index)).filter_map(narrow).collect()
    }

    /// The runs of returns that belong together.
    fn runs(&self, belongs_to_next: impl Fn(usize) -> bool) -> impl Iterator<Item = Range<usize>> {
        object_runs(self.returns.len(), is_full_turn(self.scan), belongs_to_next)
    }

    /// The return at an index, which may continue at the beginning of the list.
    const fn at(&self, index: usize) -> &Return {
        &self.returns[index % self.returns.len()]
    }

    /// Whether a return and the next one belong to one object.
    fn belongs_to_next(&self, index: usize) -> bool {
        let (scan, one, next) = (self.scan, self.at(index), self.at(index + 1));
        let beams = scan.ranges.len();
        let steps = (next.beam + beams - one.beam) % beams;
        if steps == 0 || steps > MAX_MISSING + 1 {
            return false;
        }
        let missing = |step: usize| scan.ranges[(one.beam + step) % beams].is_nan();
        if !(1..steps).all(missing) {
            return false;
        }
        if let (Some(owner), Some(other)) = (one.owner, next.owner)
            && owner != other
        {
            return false;
        }
        let spacing_m = one.range_m.min(next.range_m) * scan.angle_increment * steps as f64;
        (next.point - one.point).norm() < NEAR_M + NEAR_SPACINGS * spacing_m
    }

    fn cluster(&self, first: usize, count: usize) -> Cluster {
        let (scan, last) = (self.scan, first + count - 1);
        let beams = scan.ranges.len();
        let (begin, end) = (self.at(first), self.at(last));
        let steps = (end.beam + beams - begin.beam) % beams;
        let ranges_m = (first..=last).map(|index| self.at(index).range_m);
        let half_beam = scan.angle_increment / 2.0;
        Cluster {
            first,
            count,
            near_m: ranges_m.fold(f64::INFINITY, f64::min),
            right: self.pose.yaw + scan.angle(begin.beam) - half_beam,
            spread: (steps + 1) as f64 * scan.angle_increment,
            own_edges: [is_edge(scan, begin, false), is_edge(scan, end, true)],
            joins: [self.joins_settled(first, false), self.joins_settled(last, true)],
            length_m: (end.point - begin.point).norm(),
        }
    }

    /// Whether the return next to one, at its left or right, belongs to it and to a settled mark.
    fn joins_settled(&self, index: usize, to_left: bool) -> bool {
        let next_to = if to_left { index + 1 } else { index + self.returns.len() - 1 };
        let first = if to_left { index } else { next_to };
        !self.at(next_to).is_candidate && self.belongs_to_next(first)
    }
}

/// Whether the beam next to a return, at its left or right, goes beyond it.
fn is_edge(scan: &Scan, edge: &Return, to_left: bool) -> bool {
    let beams = scan.ranges.len();
    let next_to = if to_left { edge.beam + 1 } else { edge.beam + beams - 1 };
    let leaves_fan = if to_left { edge.beam + 1 == beams } else { edge.beam == 0 };
    if leaves_fan && !is_full_turn(scan) {
        return false;
    }
    scan.ranges[next_to % beams] > edge.range_m + BEYOND_EDGE_M
}

/// Least and largest radius of a moving obstacle, metres.
pub(super) const RADII_M: (f64, f64) = (0.1, 0.7);

/// Standard deviation of a return from a disc's outline, metres: noise of the range, and bodies that are not round.
const OUTLINE_DEVIATION_M: f64 = 0.02;
/// Standard deviation of the robot's position, metres, and of its heading, radians.
const PLACE_DEVIATION_M: f64 = 0.01;
const YAW_DEVIATION: f64 = 0.005;
/// Steps of the fit; each squares the remaining relative error.
const STEPS: usize = 3;

/// A radius and its variance, metres and square metres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Radius {
    pub radius_m: f64,
    pub variance: f64,
}

impl Cluster {
    /// Every n-th return, where n is the stride.
    pub fn returns<'a>(
        &self,
        returns: &'a [Return],
        stride: usize,
    ) -> impl Iterator<Item = &'a Return> + use<'a> {
        let indices = (self.first..self.first + self.count).step_by(stride);
        indices.map(|index| &returns[index % returns.len()])
    }

    /// The first, middle and last point.
    pub fn sample(&self, returns: &[Return]) -> [Point; 3] {
        [0, self.count / 2, self.count - 1]
            .map(|step| returns[(self.first + step) % returns.len()].point)
    }

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
    pub fn rough_center(&self, lidar: &Point, radius_m: f64, increment: f64) -> Point {
        let (direction, _) = self.toward(radius_m, increment);
        let (sin, cos) = libm::sincos(direction);
        lidar + Vector::new(cos, sin) * (self.near_m + radius_m)
    }

    /// The disc of this radius that fits returns and edges best, by least squares (Gauss-Newton).
    pub fn fit(&self, returns: &[Return], lidar: &Point, radius_m: f64, increment: f64) -> Fit {
        let (direction, lateral_m) = self.toward(radius_m, increment);
        let (sin, cos) = libm::sincos(direction);
        let ahead = Vector::new(cos, sin);
        let across = Vector::new(-sin, cos).to_column();
        let distance = self.near_m + radius_m;
        let rough = lidar + ahead * distance;
        let mut center = rough;
        let outline = OUTLINE_DEVIATION_M.powi(2).recip();
        let lateral = lateral_m.max(PLACE_DEVIATION_M / 2.0).powi(2).recip();
        let mut spread = Matrix2::identity();
        for _ in 0..STEPS {
            let mut normal = across * across.transpose() * lateral;
            let mut wanted = across * (-across.dot(&(center - lidar).to_column()) * lateral);
            for Return { point, .. } in self.returns(returns, 1) {
                let outward = center - point;
                let apart = outward.norm().max(1e-6);
                let outward = (outward / apart).to_column();
                normal += outward * outward.transpose() * outline;
                wanted += outward * ((radius_m - apart) * outline);
            }
            let Some(inverse) = normal.try_inverse() else {
                break;
            };
            let step = inverse * wanted;
            center = center + Vector::new(step.x, step.y);
            spread = inverse;
        }
        let is_consistent = (center - rough).norm() < radius_m;
        if !is_consistent {
            center = rough;
            spread = Matrix2::identity() * radius_m.powi(2);
        }
        let pose_m = PLACE_DEVIATION_M.powi(2) + (YAW_DEVIATION * distance).powi(2);
        Fit { center, covariance: spread + Matrix2::identity() * pose_m }
    }

    /// The radius of a disc whose nearest point is at a distance, metres, by the angle between its edges; `None` where an edge
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
