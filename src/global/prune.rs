//! Removal of redundant nodes (paper, section 3.2.2, eqs. 20-23).

use super::line_of_sight::is_clear;
use super::path::Path;
use crate::geometry::Point;
use crate::map::FreeSpace;

/// The shortest chain of a path's own nodes, in their order, in which each sees the next.
///
/// Nodes on a straight stretch are merged first. Then `L(A, D)` is minimised over all insertions, as the equations have
/// it, not only greedily: node by node, the cheapest predecessor that it sees. Never longer than the path given, whose
/// segments must be clear.
#[must_use]
pub fn prune(space: &FreeSpace, path: &Path) -> Path {
    let nodes = merge_collinear(path.points());
    let mut best_m = vec![0.0; nodes.len()];
    let mut before = vec![0; nodes.len()];
    for node in 1..nodes.len() {
        // Cheapest first, so that most lines of sight need not be looked at.
        let mut candidates: Vec<(f64, usize)> = (0..node)
            .map(|earlier| {
                (
                    best_m[earlier] + (nodes[node] - nodes[earlier]).norm(),
                    earlier,
                )
            })
            .collect();
        candidates.sort_by(|one, other| one.0.total_cmp(&other.0).then(one.1.cmp(&other.1)));
        let seen = candidates
            .into_iter()
            .find(|&(_, earlier)| {
                earlier + 1 == node || is_clear(space, &nodes[earlier], &nodes[node])
            })
            .expect("the node just before is always among the candidates");
        (best_m[node], before[node]) = seen;
    }
    let mut chain = Vec::new();
    let mut node = nodes.len() - 1;
    chain.push(nodes[node]);
    while node > 0 {
        node = before[node];
        chain.push(nodes[node]);
    }
    chain.reverse();
    Path::new(chain)
}

/// The nodes where the direction changes, with both ends.
fn merge_collinear(points: &[Point]) -> Vec<Point> {
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
