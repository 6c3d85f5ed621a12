//! From the scans of a log to poses: scan matching to the latest scans, closed loops, refinement.

use super::log_scans::LogScan;
use super::loops::Loops;
use super::matching::{Match, match_scan};
use super::pose_graph::{Edge, optimize};
use super::score_grid::ScoreGrid;
use super::surfels::{Surfel, SurfelMap, surfels};
use crate::geometry::Pose;
use crate::localization::{DeskewedScan, coarse_search, information_of};

/// A scan becomes a node of the graph when the robot moved by this since the last one, metres or radians.
const NODE_M: f64 = 0.25;
const NODE_RAD: f64 = 0.2;

/// A scan is matched to at most this many of the latest nodes, and to those within a distance, metres.
const LOCAL_NODES: usize = 20;
const LOCAL_M: f64 = 10.0;

/// Standard deviations of odometry after one metre and one radian, as those of a localizer for sparse scans, and at rest.
const M_PER_M: f64 = 0.05;
const M_PER_RAD: f64 = 0.05;
const RAD_PER_M: f64 = 0.03;
const RAD_PER_RAD: f64 = 0.2;
const AT_REST_M: f64 = 0.01;
const AT_REST_RAD: f64 = 0.02;

/// Standard deviations of a scan's place around that of the scan before, where the odometry's place does not match, metres and
/// radians.
const JUMP_SIGMA_M: f64 = 0.3;
const JUMP_SIGMA_RAD: f64 = 0.2;

/// A robot may have been carried where this many scans in a row do not match, although its odometry stands still.
const UNMATCHED_IN_A_ROW: usize = 2;

/// Nodes near each other are matched again after all loops are closed: distance, metres, number for each node, and rounds.
const REFINED_M: f64 = 5.0;
const REFINED_NODES: usize = 10;
const ROUNDS: usize = 3;
/// Standard deviations of their poses relative to each other, metres and radians (information 100 and 1000).
const REFINED_SIGMA_M: f64 = 0.1;
const REFINED_SIGMA_RAD: f64 = 0.0316;

/// A node: a scan with its surface points, in the robot's frame.
pub(super) struct Node<'a> {
    pub scan: &'a DeskewedScan,
    pub surfels: Vec<Surfel>,
}

/// Poses of scans, and what they rest on.
pub(super) struct Solved {
    /// A pose for each scan.
    pub poses: Vec<Pose>,
    pub nodes: usize,
    /// Distances of the closed loops' measured positions from the final ones, metres.
    pub loop_errors_m: Vec<f64>,
    /// The same of the nodes at places where the robot was before.
    pub revisit_errors_m: Vec<f64>,
    pub unmatched: usize,
    /// Indices of scans, see [`MappedLog`](super::MappedLog).
    pub odometry_jumps: Vec<usize>,
    pub gaps: Vec<usize>,
}

/// What the place of a scan relative to the scans before it rests on.
enum Basis {
    /// The scan matches where the odometry puts it.
    Match,
    /// It matches near the scan before it only.
    MatchAgainstOdometry,
    /// It matches at neither place, and follows the odometry.
    Odometry,
}

/// The latest nodes as a map.
struct LocalMap {
    surfels: SurfelMap,
    scores: Option<ScoreGrid>,
}

/// Estimates the poses of scans. The first scan is at `start`. `on_scan` is called after each.
pub(super) fn solve(scans: &[LogScan], start: &Pose, on_scan: &mut dyn FnMut()) -> Solved {
    let mut nodes: Vec<Node<'_>> = Vec::new();
    let mut poses: Vec<Pose> = Vec::new();
    let mut edges: Vec<Edge> = Vec::new();
    // Node and pose in its frame of each scan.
    let mut places: Vec<(usize, Pose)> = Vec::new();
    let mut loops = Loops::default();
    let mut local = None;
    let (mut unmatched, mut last_matched, mut in_a_row) = (0, 0, 0);
    let (mut odometry_jumps, mut gaps) = (Vec::new(), Vec::new());
    for (index, scan) in scans.iter().enumerate() {
        let Some(last) = nodes.len().checked_sub(1) else {
            nodes.push(Node { scan: &scan.scan, surfels: surfels(&scan.scan) });
            poses.push(*start);
            places.push((0, Pose::default()));
            on_scan();
            continue;
        };
        let (_, before) = places[index - 1];
        let moved = scans[index - 1].odometry.inverse_transform_pose(&scan.odometry);
        let local = local.get_or_insert_with(|| local_map(&nodes, &poses));
        let (found, basis) = track(scan, local, &before, &moved, sigmas(scans, index));
        match basis {
            Basis::Match => (last_matched, in_a_row) = (index, 0),
            Basis::MatchAgainstOdometry => {
                (last_matched, in_a_row) = (index, 0);
                odometry_jumps.push(index);
            }
            Basis::Odometry => {
                unmatched += 1;
                in_a_row += 1;
                let gap = if is_far(&moved) {
                    Some(index)
                } else {
                    (in_a_row == UNMATCHED_IN_A_ROW).then_some(index + 1 - UNMATCHED_IN_A_ROW)
                };
                // A far step is a gap already where the scan after it does not match either.
                gaps.extend(gap.filter(|gap| gaps.last() != Some(gap)));
            }
        }
        if !is_far(&found.pose) {
            places.push((last, found.pose));
            on_scan();
            continue;
        }
        let node = nodes.len();
        nodes.push(Node { scan: &scan.scan, surfels: surfels(&scan.scan) });
        poses.push(poses[last].transform_pose(&found.pose));
        edges.push(Edge {
            from: last,
            to: node,
            motion: found.pose,
            information: found.information,
            is_uncertain: false,
        });
        places.push((node, Pose::default()));
        if loops.close(&nodes, &poses, &mut edges) {
            optimize(&mut poses, &edges);
        }
        *local = local_map(&nodes, &poses);
        on_scan();
    }
    gaps.retain(|gap| *gap < last_matched);
    let mut near = Vec::new();
    for _ in 0..ROUNDS {
        near = refined(&nodes, &poses);
        let all: Vec<Edge> = edges.iter().chain(&near).copied().collect();
        optimize(&mut poses, &all);
    }
    let error_m = |edge: &Edge| {
        let motion = poses[edge.from].inverse_transform_pose(&poses[edge.to]);
        (motion.position() - edge.motion.position()).norm()
    };
    let loop_errors_m = edges.iter().filter(|edge| edge.is_uncertain).map(error_m).collect();
    // Not matched to each other before.
    let is_revisit = |edge: &&Edge| edge.to - edge.from > LOCAL_NODES;
    let revisit_errors_m = near.iter().filter(is_revisit).map(error_m).collect();
    let pose = |(node, place): &(usize, Pose)| poses[*node].transform_pose(place);
    Solved {
        poses: places.iter().map(pose).collect(),
        nodes: nodes.len(),
        loop_errors_m,
        revisit_errors_m,
        unmatched,
        odometry_jumps,
        gaps,
    }
}

/// Whether a motion is that from one node to the next.
fn is_far(moved: &Pose) -> bool {
    libm::hypot(moved.x, moved.y) >= NODE_M || moved.yaw.abs() >= NODE_RAD
}

/// The latest nodes in the frame of the last one.
fn local_map(nodes: &[Node<'_>], poses: &[Pose]) -> LocalMap {
    let last = poses[poses.len() - 1];
    let first = nodes.len().saturating_sub(LOCAL_NODES);
    let is_near = |node: &usize| (poses[*node].position() - last.position()).norm() < LOCAL_M;
    let used = (first..nodes.len()).filter(is_near);
    let surfels = SurfelMap::new(
        used.map(|node| (last.inverse_transform_pose(&poses[node]), &nodes[node].surfels[..])),
    );
    let scores = ScoreGrid::fine(surfels.surfels());
    LocalMap { surfels, scores }
}

/// Standard deviations of the odometry from the scan before to a scan, metres and radians. The stamps of lidar and odometry may
/// differ, so the turns just before and after count as well.
fn sigmas(scans: &[LogScan], index: usize) -> (f64, f64) {
    let step = |to: usize| {
        let ends = to.checked_sub(1).and_then(|from| Some((scans.get(from)?, scans.get(to)?)));
        ends.map_or_else(Pose::default, |(from, to)| {
            from.odometry.inverse_transform_pose(&to.odometry)
        })
    };
    let moved = step(index);
    let turns = [index - 1, index, index + 1].map(|to| step(to).yaw.abs());
    let (distance_m, turned) =
        (libm::hypot(moved.x, moved.y), turns.into_iter().fold(0.0, f64::max));
    (
        AT_REST_M + M_PER_M * distance_m.sqrt() + M_PER_RAD * turned,
        AT_REST_RAD + RAD_PER_M * distance_m.sqrt() + RAD_PER_RAD * turned,
    )
}

/// Matches a scan to the latest nodes: where the odometry puts it, or else near the scan before it, since the odometry may have
/// jumped. The odometry's pose if it does not match.
fn track(
    scan: &LogScan,
    local: &LocalMap,
    before: &Pose,
    moved: &Pose,
    sigmas: (f64, f64),
) -> (Match, Basis) {
    let predicted = before.transform_pose(moved);
    let prior = information_of(sigmas.0, sigmas.1);
    let mut found = local.find(&scan.scan, &predicted, sigmas);
    if !found.is_good() || scan.is_after_jump {
        let mut near = local.find(&scan.scan, before, (JUMP_SIGMA_M, JUMP_SIGMA_RAD));
        // After a jump, the walls of a corridor match at the odometry's place, too.
        if near.is_certain() || scan.is_after_jump && near.is_good() {
            near.information += information_of(JUMP_SIGMA_M, JUMP_SIGMA_RAD);
            return (near, Basis::MatchAgainstOdometry);
        }
    }
    if found.is_good() {
        found.information += prior;
        return (found, Basis::Match);
    }
    (found.pose, found.information) = (predicted, prior);
    (found, Basis::Odometry)
}

impl LocalMap {
    /// Matches a scan around a pose with these standard deviations.
    fn find(&self, scan: &DeskewedScan, around: &Pose, sigmas: (f64, f64)) -> Match {
        let begin = self.scores.as_ref().map_or(*around, |scores| {
            let ends = scan.hits.iter().map(|hit| hit.end);
            coarse_search(ends, around, sigmas, scores)
        });
        match_scan(&self.surfels, scan, begin, around, &information_of(sigmas.0, sigmas.1))
    }
}

/// Edges between each node and those near it that are not its neighbours in time.
fn refined(nodes: &[Node<'_>], poses: &[Pose]) -> Vec<Edge> {
    let mut wanted: Vec<(usize, usize)> = Vec::new();
    for to in 0..nodes.len() {
        let mut near: Vec<(f64, usize)> = (0..to.saturating_sub(1))
            .map(|from| ((poses[from].position() - poses[to].position()).norm(), from))
            .filter(|(distance_m, _)| *distance_m < REFINED_M)
            .collect();
        near.sort_by(|one, other| one.0.total_cmp(&other.0));
        wanted.extend(near.iter().take(REFINED_NODES).map(|(_, from)| (*from, to)));
    }
    wanted.sort_unstable();
    let prior = information_of(REFINED_SIGMA_M, REFINED_SIGMA_RAD);
    let mut edges = Vec::new();
    let mut map: Option<(usize, SurfelMap)> = None;
    for (from, to) in wanted {
        if map.as_ref().is_none_or(|(node, _)| *node != from) {
            let around = from.saturating_sub(1)..(from + 2).min(nodes.len());
            let placed = around.map(|node| {
                (poses[from].inverse_transform_pose(&poses[node]), &nodes[node].surfels[..])
            });
            map = Some((from, SurfelMap::new(placed)));
        }
        let Some((_, map)) = &map else { continue };
        let predicted = poses[from].inverse_transform_pose(&poses[to]);
        let found = match_scan(map, nodes[to].scan, predicted, &predicted, &prior);
        if found.is_good() {
            let (motion, information) = (found.pose, found.information);
            edges.push(Edge { from, to, motion, information, is_uncertain: true });
        }
    }
    edges
}
