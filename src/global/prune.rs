//! Removal of redundant nodes (paper, section 3.2.2, eqs. 20-23).

use super::line_of_sight::{has_line_of_sight, is_blocked_at, obstruction};
use super::path::Path;
use super::{ClearanceCosts, Pruning};
use crate::geometry::Point;
use crate::map::FreeSpace;

/// Largest number of nodes that an edge of the chain may skip. This bounds the work on long paths.
const MAX_SKIPPED: usize = 4096;

/// Smallest improvement that counts, metres: nodes on a straight stretch differ by rounding only.
const MIN_GAIN_M: f64 = 1e-9;

/// Up to this number of nodes, all nodes take part. With twice as many, every second node of straight stretches does, and so
/// on.
const FEW_NODES: usize = 32;

/// Largest stride between participating nodes of a straight stretch.
const MAX_STRIDE: usize = 16;

/// Iterations in which each node of the chain moves to its best place between its neighbours.
const MAX_ITERATIONS: usize = 4;

/// Finds the shortest chain of a path's nodes, in order, in which each has a line of sight to the next.
///
/// `L(A, D)` is minimised over all insertions, as in the equations, by dynamic programming: for each node, the cheapest
/// visible predecessor. Nodes on straight stretches take part as well, since the best path around a corner may leave the
/// stretch at any point.
///
/// [`Pruning::Sparse`] is identical on a path of up to 63 nodes. On a longer path, all corners and their neighbours take
/// part, but only one node in up to 16 on straight stretches. Each node of the chain then moves along the path, between
/// its neighbours, to where the chain is shortest. The result is on average within a thousandth of the optimum.
///
/// The chain is never longer than the path, up to rounding; the path's segments must be clear in `space` (see
/// [`is_clear`](super::is_clear)). With costs, lengths are equivalent lengths. Both ends are kept exactly. Remaining nodes on
/// straight stretches are merged. The run time is quadratic in the number of participating nodes.
#[must_use]
pub fn prune(
    space: &FreeSpace,
    costs: Option<&ClearanceCosts>,
    path: &Path,
    pruning: Pruning,
) -> Path {
    let nodes = path.points();
    let frame = space.frame();
    let candidates = Candidates {
        space,
        costs,
        nodes,
        in_cells: nodes.iter().map(|node| frame.to_cell_units(node)).collect(),
    };
    let stride = match pruning {
        Pruning::Sparse => (nodes.len() / FEW_NODES).clamp(1, MAX_STRIDE),
        Pruning::Thorough => 1,
    };
    let mut chain = candidates.shortest_chain(&participating(nodes, stride));
    if stride > 1 {
        candidates.slide(&mut chain, stride);
    }
    let chain: Vec<Point> = chain.into_iter().map(|node| nodes[node]).collect();
    Path::new(merge_collinear(&chain))
}

/// Both ends, all corners with the adjacent nodes, and every `stride`-th node.
fn participating(nodes: &[Point], stride: usize) -> Vec<usize> {
    let last = nodes.len() - 1;
    let is_corner = |node: usize| !is_straight(&nodes[node - 1], &nodes[node], &nodes[node + 1]);
    let mut takes_part: Vec<bool> = (0..=last).map(|node| node.is_multiple_of(stride)).collect();
    takes_part[last] = true;
    for corner in (1..last).filter(|&node| is_corner(node)) {
        takes_part[corner - 1..=corner + 1].fill(true);
    }
    (0..=last).filter(|&node| takes_part[node]).collect()
}

/// The nodes of a path, in metres and in cell units, with the free space and costs between them.
struct Candidates<'a> {
    space: &'a FreeSpace,
    costs: Option<&'a ClearanceCosts>,
    nodes: &'a [Point],
    in_cells: Vec<Point>,
}

impl Candidates<'_> {
    fn length_m(&self, from: usize, to: usize) -> f64 {
        (self.nodes[to] - self.nodes[from]).norm()
    }

    /// Cost of a straight segment, in metres of open space; at least its length.
    fn cost_m(&self, from: usize, to: usize, length_m: f64) -> f64 {
        self.costs.map_or(length_m, |costs| {
            let resolution_m = self.space.frame().resolution_m;
            costs.equivalent_length(&self.in_cells[from], &self.in_cells[to]) * resolution_m
        })
    }

    /// The cheapest chain over the given nodes, in order, from the first to the last.
    fn shortest_chain(&self, nodes: &[usize]) -> Vec<usize> {
        let mut best_m = vec![0.0; nodes.len()];
        let mut before = vec![0; nodes.len()];
        // Where the last line of sight from each node was blocked. The next node is close to the last, so it is probably
        // blocked at the same place.
        let mut blocked_at = vec![0.0; nodes.len()];
        for (place, &node) in nodes.iter().enumerate().skip(1) {
            let neighbour = nodes[place - 1];
            let neighbour_m = self.cost_m(neighbour, node, self.length_m(neighbour, node));
            let mut best = (best_m[place - 1] + neighbour_m, place - 1);
            // The predecessor of the last node is often the best again, and gives a tight bound for the others.
            let last_choice = before[place - 1];
            let first = place.saturating_sub(MAX_SKIPPED);
            for earlier in core::iter::once(last_choice.max(first)).chain(first..place - 1) {
                // Comparing squares avoids a square root for most candidates.
                let bound_m = best.0 - MIN_GAIN_M - best_m[earlier];
                let squared = (self.nodes[node] - self.nodes[nodes[earlier]]).norm_squared();
                if bound_m <= 0.0 || squared >= bound_m * bound_m {
                    continue;
                }
                let (from, to) = (&self.in_cells[nodes[earlier]], &self.in_cells[node]);
                if is_blocked_at(self.space, from, to, blocked_at[earlier]) {
                    continue;
                }
                if let Some(fraction) = obstruction(self.space, from, to) {
                    blocked_at[earlier] = fraction;
                    continue;
                }
                let cost_m = self.cost_m(nodes[earlier], node, squared.sqrt());
                if cost_m < bound_m {
                    best = (best_m[earlier] + cost_m, earlier);
                }
            }
            (best_m[place], before[place]) = best;
        }
        let earlier = |&place: &usize| (place > 0).then(|| before[place]);
        let places = core::iter::successors(Some(nodes.len() - 1), earlier);
        let mut chain: Vec<usize> = places.map(|place| nodes[place]).collect();
        chain.reverse();
        chain
    }

    /// Moves each inner node of a chain to the best node within `reach` nodes along the path in both directions.
    fn slide(&self, chain: &mut [usize], reach: usize) {
        for _ in 0..MAX_ITERATIONS {
            let mut has_moved = false;
            for place in 1..chain.len().saturating_sub(1) {
                let [from, here, to] = [chain[place - 1], chain[place], chain[place + 1]];
                let onwards = here + 1..=(here + reach).min(to - 1);
                let back = here.saturating_sub(reach).max(from + 1)..=here - 1;
                let further = self.best_between((from, to), here, onwards);
                chain[place] = self.best_between((from, to), further, back.rev());
                has_moved |= chain[place] != here;
            }
            if !has_moved {
                return;
            }
        }
    }

    /// The best node between two others: `here`, or one of `others` up to the first better one that is not visible from
    /// both. Nodes beyond that are rarely visible.
    fn best_between(
        &self,
        (from, to): (usize, usize),
        here: usize,
        others: impl Iterator<Item = usize>,
    ) -> usize {
        let cost_m = |node| {
            self.cost_m(from, node, self.length_m(from, node))
                + self.cost_m(node, to, self.length_m(node, to))
        };
        let is_visible = |node: usize| {
            let [from, node, to] = [from, node, to].map(|node| &self.in_cells[node]);
            has_line_of_sight(self.space, from, node) && has_line_of_sight(self.space, node, to)
        };
        let mut best = (cost_m(here), here);
        for node in others {
            let improves = |cost_m: f64| cost_m < best.0 - MIN_GAIN_M;
            // The length is a lower bound of the cost.
            if improves(self.length_m(from, node) + self.length_m(node, to))
                && improves(cost_m(node))
            {
                if !is_visible(node) {
                    break;
                }
                best = (cost_m(node), node);
            }
        }
        best.1
    }
}

/// Both ends and the nodes at which the direction changes.
pub(super) fn merge_collinear(points: &[Point]) -> Vec<Point> {
    let mut merged: Vec<Point> = Vec::new();
    for &point in points {
        if let [.., before, last] = merged[..]
            && is_straight(&before, &last, &point)
        {
            merged.pop();
        }
        merged.push(point);
    }
    merged
}

/// Whether three points are consecutive points of a line, up to rounding.
fn is_straight(before: &Point, here: &Point, after: &Point) -> bool {
    let (one, other) = (here - before, after - here);
    one.perp(&other).abs() <= 1e-9 * one.norm() * other.norm() && one.dot(&other) > 0.0
}
