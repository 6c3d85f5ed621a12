//! Runs of returns that belong together: what one thing shows of itself.

use crate::geometry::{Point, Pose};
use crate::map::Scan;

use super::super::scan_visibility::is_full_turn;

/// A return that the map does not explain.
#[derive(Clone, Copy, Debug)]
pub(super) struct Return {
    pub beam: usize,
    pub range_m: f64,
    pub point: Point,
    /// Whether it may belong to something new or moving.
    pub is_candidate: bool,
    /// The track, by its place in the list, on whose expected disc it falls.
    pub owner: Option<usize>,
}

/// Consecutive returns of one thing.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cluster {
    /// Place of the first in the list of returns; the run may go on at the list's beginning.
    pub first: usize,
    /// Number of returns.
    pub count: usize,
    /// Shortest range, metres.
    pub near_m: f64,
    /// Direction of its right edge in the map frame, radians: half a beam before the first return.
    pub right: f64,
    /// Angle from there to its left edge, radians.
    pub spread: f64,
    /// Whether its right and left edges are its own: the beams beside them go on beyond it.
    pub own_edges: [bool; 2],
    /// Whether it goes on to its right and to its left in something that has stood there for a while.
    pub joins: [bool; 2],
    /// Distance from the first return to the last, metres.
    pub length_m: f64,
}

/// Returns of neighbouring beams are this near to each other, metres, and so many beam spacings more: 0.1 m lies
/// between two people who pass close by each other, and more between a person and the wall behind.
const NEAR_M: f64 = 0.1;
const NEAR_SPACINGS: f64 = 2.0;
/// So many beams without a measurement do not part what they lie between.
const MOST_MISSING: usize = 3;
/// A beam goes on beyond an edge if it is this much longer than the one on the edge, metres.
const BEYOND_EDGE_M: f64 = 0.05;
/// What is longer than this, metres, is no disc of at most 0.7 m radius.
pub(super) const LONGEST_M: f64 = 1.5;

/// Finds the runs; those too long for a disc are cut where the expected disc of a moving thing ends.
pub(super) fn sightings(
    pose: &Pose,
    scan: &Scan,
    returns: &[Return],
    spare: &mut Vec<(usize, usize)>,
    found: &mut Vec<Cluster>,
) {
    found.clear();
    spare.clear();
    for (place, next) in returns.iter().enumerate() {
        if !next.is_candidate {
            continue;
        }
        match spare.last_mut() {
            Some((first, count))
                if *first + *count == place && belong_together(scan, &returns[place - 1], next) =>
            {
                *count += 1;
            }
            _ => spare.push((place, 1)),
        }
    }
    join_at_seam(scan, returns, spare);
    for &(first, count) in spare.iter() {
        let whole = sighting(pose, scan, returns, first, count);
        if whole.length_m <= LONGEST_M {
            found.push(whole);
            continue;
        }
        let owner = |step: usize| returns[(first + step) % returns.len()].owner;
        let mut from = 0;
        for step in 1..=count {
            if step == count || owner(step) != owner(from) {
                let part = sighting(
                    pose,
                    scan,
                    returns,
                    (first + from) % returns.len(),
                    step - from,
                );
                found.push(part);
                from = step;
            }
        }
    }
}

/// On a full turn the last beam's neighbour is the first.
fn join_at_seam(scan: &Scan, returns: &[Return], runs: &mut Vec<(usize, usize)>) {
    let (Some(&(first, count)), Some(&(last, last_count))) = (runs.first(), runs.last()) else {
        return;
    };
    let spans_seam = first == 0 && last + last_count == returns.len() && runs.len() > 1;
    let (before, after) = (&returns[returns.len() - 1], &returns[0]);
    if spans_seam && is_full_turn(scan) && belong_together(scan, before, after) {
        runs[0] = (last, last_count + count);
        runs.pop();
    }
}

/// Whether a return and the next go on without a jump.
fn belong_together(scan: &Scan, one: &Return, next: &Return) -> bool {
    let beams = scan.ranges.len();
    let steps = (next.beam + beams - one.beam) % beams;
    if steps == 0 || steps > MOST_MISSING + 1 {
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

fn sighting(pose: &Pose, scan: &Scan, returns: &[Return], first: usize, count: usize) -> Cluster {
    let beams = scan.ranges.len();
    let at = |step: usize| &returns[(first + step) % returns.len()];
    let (begin, end) = (at(0), at(count - 1));
    let steps = (end.beam + beams - begin.beam) % beams;
    let near_m = (0..count)
        .map(|step| at(step).range_m)
        .fold(f64::INFINITY, f64::min);
    let half_beam = scan.angle_increment / 2.0;
    Cluster {
        first,
        count,
        near_m,
        right: pose.yaw + scan.angle(begin.beam) - half_beam,
        spread: (steps + 1) as f64 * scan.angle_increment,
        own_edges: [is_edge(scan, begin, false), is_edge(scan, end, true)],
        joins: [
            joins_settled(scan, returns, first, false),
            joins_settled(scan, returns, (first + count - 1) % returns.len(), true),
        ],
        length_m: (end.point - begin.point).norm(),
    }
}

/// Whether what is seen beside a return, to its left or its right, has stood there for a while and is near to it.
fn joins_settled(scan: &Scan, returns: &[Return], place: usize, to_left: bool) -> bool {
    let all = returns.len();
    let beside = if to_left {
        (place + 1) % all
    } else {
        (place + all - 1) % all
    };
    let (one, next) = if to_left {
        (place, beside)
    } else {
        (beside, place)
    };
    !returns[beside].is_candidate && belong_together(scan, &returns[one], &returns[next])
}

/// Whether the beam beside a return, to its left or its right, goes on beyond it.
fn is_edge(scan: &Scan, edge: &Return, to_left: bool) -> bool {
    let beams = scan.ranges.len();
    let beside = if to_left {
        edge.beam + 1
    } else {
        edge.beam + beams - 1
    };
    let leaves_fan = if to_left {
        edge.beam + 1 == beams
    } else {
        edge.beam == 0
    };
    if leaves_fan && !is_full_turn(scan) {
        return false;
    }
    scan.ranges[beside % beams] > edge.range_m + BEYOND_EDGE_M
}
