//! Removal of redundant nodes (paper, section 3.2.2, eqs. 20-23).

use super::ClearanceCosts;
use super::line_of_sight::{is_blocked_at, obstruction};
use super::path::Path;
use crate::geometry::Point;
use crate::map::FreeSpace;

/// An edge of the chain skips at most this many nodes of the path, which bounds the work on paths of many thousand nodes.
const MOST_SKIPPED: usize = 4096;

/// A detour shorter than this is no reason to look again, metres: nodes on a straight stretch differ by rounding only.
const GAIN_M: f64 = 1e-9;

/// The shortest chain of a path's own nodes, in their order, in which each sees the next.
///
/// `L(A, D)` is minimised over all insertions, as the equations have it, not only greedily: node by node, the cheapest
/// predecessor that it sees, among all nodes up to 4096 back. Nodes on a straight stretch take part, since the best way
/// round a corner may leave the stretch anywhere; those left on one in the end are merged. The chain is never longer
/// than the path given (up to rounding), whose segments must be clear in `space`; lines of sight are
/// [`is_clear`](super::is_clear). With costs, shortest and longer are by them. Ends are kept exactly. Quadratic in the
/// number of nodes.
#[must_use]
pub fn prune(space: &FreeSpace, costs: Option<&ClearanceCosts>, path: &Path) -> Path {
    let nodes = path.points();
    let frame = space.frame();
    let in_cells: Vec<Point> = nodes.iter().map(|node| frame.to_cell_units(node)).collect();
    let weighed = |earlier: usize, node: usize, length_m: f64| {
        costs.map_or(length_m, |costs| {
            costs.along(&in_cells[earlier], &in_cells[node]) * frame.resolution_m
        })
    };
    let mut best_m = vec![0.0; nodes.len()];
    let mut before = vec![0; nodes.len()];
    // Where the last line of sight from each node was blocked: the next node is near the last, and so is what blocks it.
    let mut blocked_at = vec![0.0; nodes.len()];
    for node in 1..nodes.len() {
        let length_m = |earlier: usize| (nodes[node] - nodes[earlier]).norm();
        let neighbour_m = best_m[node - 1] + weighed(node - 1, node, length_m(node - 1));
        let mut best = (neighbour_m, node - 1);
        // What the last node came from is most often the answer again, and a good bound for the rest.
        let last_choice = before[node - 1];
        let first = node.saturating_sub(MOST_SKIPPED);
        for earlier in core::iter::once(last_choice.max(first)).chain(first..node - 1) {
            let (from, to) = (&in_cells[earlier], &in_cells[node]);
            if is_blocked_at(space, from, to, blocked_at[earlier]) {
                continue;
            }
            // No ground is cheaper than open ground, so the length is a bound.
            let length_m = length_m(earlier);
            let improves = |cost_m: f64| best_m[earlier] + cost_m < best.0 - GAIN_M;
            if !improves(length_m) {
                continue;
            }
            if let Some(share) = obstruction(space, from, to) {
                blocked_at[earlier] = share;
                continue;
            }
            let cost_m = weighed(earlier, node, length_m);
            if improves(cost_m) {
                best = (best_m[earlier] + cost_m, earlier);
            }
        }
        (best_m[node], before[node]) = best;
    }
    let mut chain = Vec::new();
    let mut node = nodes.len() - 1;
    chain.push(nodes[node]);
    while node > 0 {
        node = before[node];
        chain.push(nodes[node]);
    }
    chain.reverse();
    Path::new(merge_collinear(&chain))
}

/// The nodes where the direction changes, with both ends.
pub(super) fn merge_collinear(points: &[Point]) -> Vec<Point> {
    let mut merged: Vec<Point> = Vec::new();
    for &point in points {
        if let [.., before, last] = merged[..] {
            let (one, other) = (last - before, point - last);
            let straight = one.perp(&other).abs() <= 1e-9 * one.norm() * other.norm();
            if straight && one.dot(&other) > 0.0 {
                merged.pop();
            }
        }
        merged.push(point);
    }
    merged
}
