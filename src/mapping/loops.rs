//! Closed loops: a node that sees an earlier part of the map.

use core::cmp::Reverse;
use std::collections::BinaryHeap;

use super::mapper::Node;
use super::matching::match_scan;
use super::pose_graph::Edge;
use super::score_grid::{ScoreGrid, Window};
use super::surfels::SurfelMap;
use crate::geometry::{Point, Pose};
use crate::localization::information_of;

/// Number of consecutive nodes of a submap.
const SUBMAP_NODES: usize = 12;
/// Distance along the graph between attempts, and from which a submap is an earlier part of the map, metres.
const EVERY_M: f64 = 1.0;
const EARLIER_M: f64 = 10.0;
/// A submap is a candidate within this distance of its middle node plus the window, metres.
const SEEN_M: f64 = 5.0;
/// Largest number of candidates of an attempt.
const CANDIDATES: usize = 3;
/// The window grows with the distance along the graph: at the start and per metre, and its largest size.
const WINDOW_M: (f64, f64, f64) = (0.5, 0.05, 7.0);
const WINDOW_RAD: (f64, f64, f64) = (0.1, 0.006, 0.6);
/// Nodes before the current one that are searched together with it, and number of searched points.
const SEARCHED_NODES: usize = 3;
const SEARCHED_POINTS: usize = 240;
/// Smallest score of a closed loop, the value of Cartographer.
const MIN_SCORE: f64 = 0.55;
/// Standard deviations of a searched pose, metres and radians.
const SEARCHED_SIGMA_M: f64 = 0.1;
const SEARCHED_SIGMA_RAD: f64 = 0.03;

/// Consecutive nodes as a map, in the frame of the middle one.
struct Submap {
    middle: usize,
    /// None where the nodes are too far apart to be searched: the odometry jumps, or is in another unit. The index of such points
    /// would fill the memory.
    surfels: Option<SurfelMap>,
    scores: Option<ScoreGrid>,
}

/// The submaps, and the closed loops.
#[derive(Default)]
pub(super) struct Loops {
    submaps: Vec<Submap>,
    /// Distance driven since the last attempt, metres.
    since_m: f64,
}

impl Loops {
    /// Tries to close loops with the last node; adds edges. Returns whether there are new ones.
    pub fn close(&mut self, nodes: &[Node<'_>], poses: &[Pose], edges: &mut Vec<Edge>) -> bool {
        self.add_submap(nodes, poses);
        let last = nodes.len() - 1;
        self.since_m += (poses[last].position() - poses[last - 1].position()).norm();
        if self.since_m < EVERY_M {
            return false;
        }
        self.since_m = 0.0;
        let along = distances(nodes.len(), last, edges);
        let window = |submap: &Submap| {
            let along_m = along[submap.middle];
            let grown = |(start, rate, most): (f64, f64, f64)| (start + rate * along_m).min(most);
            Window {
                extent_m: grown(WINDOW_M),
                extent_rad: grown(WINDOW_RAD),
                min_score: MIN_SCORE,
            }
        };
        let mut candidates: Vec<(f64, usize)> = self
            .submaps
            .iter()
            .enumerate()
            .filter(|(_, submap)| along[submap.middle] > EARLIER_M)
            .map(|(index, submap)| {
                let distance = poses[submap.middle].position() - poses[last].position();
                (distance.norm() - window(submap).extent_m, index)
            })
            .filter(|(distance_m, _)| *distance_m < SEEN_M)
            .collect();
        candidates.sort_by(|one, other| one.0.total_cmp(&other.0).then(one.1.cmp(&other.1)));
        let points = searched_points(nodes, poses);
        let before = edges.len();
        for (_, index) in candidates.into_iter().take(CANDIDATES) {
            let window = window(&self.submaps[index]);
            edges.extend(self.submaps[index].close(nodes, poses, &points, &window));
        }
        edges.len() > before
    }

    /// Adds a submap when its last node is there.
    fn add_submap(&mut self, nodes: &[Node<'_>], poses: &[Pose]) {
        // Half of the nodes are also in the next submap.
        let first = self.submaps.len() * SUBMAP_NODES / 2;
        if nodes.len() < first + SUBMAP_NODES {
            return;
        }
        let middle = first + SUBMAP_NODES / 2;
        let placed = (first..first + SUBMAP_NODES).map(|node| {
            (poses[middle].inverse_transform_pose(&poses[node]), &nodes[node].surfels[..])
        });
        let points = placed.clone().flat_map(|(place, surfels)| {
            surfels.iter().map(move |surfel| place.transform(&surfel.point))
        });
        let surfels = ScoreGrid::frame(points).map(|_| SurfelMap::new(placed));
        self.submaps.push(Submap { middle, surfels, scores: None });
    }
}

impl Submap {
    /// The edge from the submap to the last node, if that sees it.
    fn close(
        &mut self,
        nodes: &[Node<'_>],
        poses: &[Pose],
        points: &[Point],
        window: &Window,
    ) -> Option<Edge> {
        let surfels = self.surfels.as_ref().filter(|_| !points.is_empty())?;
        if self.scores.is_none() {
            self.scores = ScoreGrid::new(surfels.surfels());
        }
        let to = nodes.len() - 1;
        let predicted = poses[self.middle].inverse_transform_pose(&poses[to]);
        let (found, _) = self.scores.as_ref()?.search(points, &predicted, window)?;
        let prior = information_of(SEARCHED_SIGMA_M, SEARCHED_SIGMA_RAD);
        let matched = match_scan(surfels, nodes[to].scan, found, &found, &prior);
        matched.is_certain().then_some(Edge {
            from: self.middle,
            to,
            motion: matched.pose,
            information: matched.information,
            is_uncertain: true,
        })
    }
}

/// Surface points of the last nodes in the frame of the last one.
fn searched_points(nodes: &[Node<'_>], poses: &[Pose]) -> Vec<Point> {
    let last = poses[poses.len() - 1];
    let first = nodes.len().saturating_sub(SEARCHED_NODES);
    let points: Vec<Point> = (first..nodes.len())
        .flat_map(|node| {
            let place = last.inverse_transform_pose(&poses[node]);
            nodes[node].surfels.iter().map(move |surfel| place.transform(&surfel.point))
        })
        .collect();
    let stride = points.len().div_ceil(SEARCHED_POINTS).max(1);
    points.into_iter().step_by(stride).collect()
}

/// Distances along the edges from a node to all others, metres (Dijkstra).
fn distances(nodes: usize, from: usize, edges: &[Edge]) -> Vec<f64> {
    let mut neighbours = vec![Vec::new(); nodes];
    for edge in edges {
        let length_m = libm::hypot(edge.motion.x, edge.motion.y);
        neighbours[edge.from].push((edge.to, length_m));
        neighbours[edge.to].push((edge.from, length_m));
    }
    let mut distances = vec![f64::INFINITY; nodes];
    distances[from] = 0.0;
    // Distances are zero or more, so their bits have the same order.
    let mut queue = BinaryHeap::from([Reverse((0_u64, from))]);
    while let Some(Reverse((bits, node))) = queue.pop() {
        let distance_m = f64::from_bits(bits);
        if distance_m > distances[node] {
            continue;
        }
        for &(next, length_m) in &neighbours[node] {
            let along_m = distance_m + length_m;
            if along_m < distances[next] {
                distances[next] = along_m;
                queue.push(Reverse((along_m.to_bits(), next)));
            }
        }
    }
    distances
}

#[cfg(test)]
mod tests {
    use super::super::surfels::Surfel;
    use super::*;
    use crate::geometry::Vector;
    use crate::localization::DeskewedScan;

    #[test]
    fn submap_of_nodes_far_apart_has_no_index() {
        let scan = DeskewedScan::default();
        let surfel = Surfel { point: Point::new(2.0, 0.0), normal: Vector::new(-1.0, 0.0) };
        let nodes: Vec<Node<'_>> =
            (0..SUBMAP_NODES).map(|_| Node { scan: &scan, surfels: vec![surfel] }).collect();
        for (step_m, has_index) in [(0.3, true), (300.0, false)] {
            let pose = |node| Pose::new(step_m * node as f64, step_m * node as f64, 0.0);
            let poses: Vec<Pose> = (0..SUBMAP_NODES).map(pose).collect();
            let mut loops = Loops::default();
            loops.add_submap(&nodes, &poses);
            assert_eq!(loops.submaps[0].surfels.is_some(), has_index, "{step_m}");
        }
    }
}
