//! Removal of redundant nodes (paper, section 3.2.2, eqs. 20-23).

use super::line_of_sight::{is_blocked_at, obstruction, sees};
use super::path::Path;
use super::{ClearanceCosts, Pruning};
use crate::geometry::Point;
use crate::map::FreeSpace;

/// An edge of the chain skips at most this many of the nodes that take part, which bounds the work on long paths.
const MOST_SKIPPED: usize = 4096;

/// A detour shorter than this is no reason to look again, metres: nodes on a straight stretch differ by rounding only.
const GAIN_M: f64 = 1e-9;

/// On straight stretches of a path of this many nodes or fewer all take part; on those of twice as many every other one,
/// and so on.
const FEW_NODES: usize = 32;

/// But no fewer than one in so many.
const MOST_SPARSE: usize = 16;

/// Times that each node of the chain is moved to its best place between its neighbours.
const ROUNDS: usize = 4;

/// The shortest chain of a path's own nodes, in their order, in which each sees the next.
///
/// `L(A, D)` is minimised over all insertions, as the equations have it, not only greedily: node by node, the cheapest
/// predecessor that it sees. All nodes take part, those on straight stretches too, since the best way round a corner may
/// leave the stretch anywhere.
///
/// [`Pruning::Sparse`] is the same on a path of up to 63 nodes. On a longer one all corners take part and the nodes beside
/// them, but on straight stretches only one node in up to 16; each node of the chain then moves along the path, between its
/// neighbours, to where it makes the chain shortest. That brings it near to the shortest: on average within a thousandth.
///
/// The chain is never longer than the path given (up to rounding), whose segments must be clear in `space`; lines of sight
/// are [`is_clear`](super::is_clear). With costs, shortest and longer are by them. Ends are kept exactly. Nodes left on a
/// straight stretch in the end are merged. Quadratic in the
/// number of nodes that take part.
#[must_use]
pub fn prune(
    space: &FreeSpace,
    costs: Option<&ClearanceCosts>,
    path: &Path,
    pruning: Pruning,
) -> Path {
    let nodes = path.points();
    let frame = space.frame();
    let sights = Sights {
        space,
        costs,
        nodes,
        in_cells: nodes.iter().map(|node| frame.to_cell_units(node)).collect(),
    };
    let sparse = match pruning {
        Pruning::Sparse => (nodes.len() / FEW_NODES).clamp(1, MOST_SPARSE),
        Pruning::Thorough => 1,
    };
    let mut chain = sights.shortest_chain(&taking_part(nodes, sparse));
    if sparse > 1 {
        sights.slide(&mut chain, sparse);
    }
    let chain: Vec<Point> = chain.into_iter().map(|node| nodes[node]).collect();
    Path::new(merge_collinear(&chain))
}

/// Both ends, all corners with the nodes beside them, and one node in so many.
fn taking_part(nodes: &[Point], sparse: usize) -> Vec<usize> {
    let last = nodes.len() - 1;
    let is_corner = |node: usize| !is_straight(&nodes[node - 1], &nodes[node], &nodes[node + 1]);
    let mut takes_part: Vec<bool> = (0..=last).map(|node| node.is_multiple_of(sparse)).collect();
    takes_part[last] = true;
    for corner in (1..last).filter(|&node| is_corner(node)) {
        takes_part[corner - 1..=corner + 1].fill(true);
    }
    (0..=last).filter(|&node| takes_part[node]).collect()
}

/// The nodes of a path, and what lies between them.
struct Sights<'a> {
    space: &'a FreeSpace,
    costs: Option<&'a ClearanceCosts>,
    nodes: &'a [Point],
    in_cells: Vec<Point>,
}

impl Sights<'_> {
    fn length_m(&self, from: usize, to: usize) -> f64 {
        (self.nodes[to] - self.nodes[from]).norm()
    }

    /// What a straight way costs, metres of open ground; no ground is cheaper, so never less than its length.
    fn cost_m(&self, from: usize, to: usize, length_m: f64) -> f64 {
        self.costs.map_or(length_m, |costs| {
            let resolution_m = self.space.frame().resolution_m;
            costs.along(&self.in_cells[from], &self.in_cells[to]) * resolution_m
        })
    }

    /// The cheapest chain over some of the nodes, in order, from the first to the last.
    fn shortest_chain(&self, nodes: &[usize]) -> Vec<usize> {
        let mut best_m = vec![0.0; nodes.len()];
        let mut before = vec![0; nodes.len()];
        // Where the last line of sight from each node was blocked: the next node is near the last, and so is what
        // blocks it.
        let mut blocked_at = vec![0.0; nodes.len()];
        for (place, &node) in nodes.iter().enumerate().skip(1) {
            let neighbour = nodes[place - 1];
            let neighbour_m = self.cost_m(neighbour, node, self.length_m(neighbour, node));
            let mut best = (best_m[place - 1] + neighbour_m, place - 1);
            // What the last node came from is most often the answer again, and a good bound for the rest.
            let last_choice = before[place - 1];
            let first = place.saturating_sub(MOST_SKIPPED);
            for earlier in core::iter::once(last_choice.max(first)).chain(first..place - 1) {
                // Squares, since there are many to ask and few to be taken.
                let wanted_m = best.0 - GAIN_M - best_m[earlier];
                let squared = (self.nodes[node] - self.nodes[nodes[earlier]]).norm_squared();
                if wanted_m <= 0.0 || squared >= wanted_m * wanted_m {
                    continue;
                }
                let (from, to) = (&self.in_cells[nodes[earlier]], &self.in_cells[node]);
                if is_blocked_at(self.space, from, to, blocked_at[earlier]) {
                    continue;
                }
                if let Some(share) = obstruction(self.space, from, to) {
                    blocked_at[earlier] = share;
                    continue;
                }
                let cost_m = self.cost_m(nodes[earlier], node, squared.sqrt());
                if cost_m < wanted_m {
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

    /// Moves each inner node of a chain to the best node at most so many further along the path or back.
    fn slide(&self, chain: &mut [usize], reach: usize) {
        for _ in 0..ROUNDS {
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

    /// The best node between two others, of one and those that follow it up to the first that would be better but is not
    /// seen by both: what lies beyond rarely is.
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
        let is_seen = |node: usize| {
            let [from, node, to] = [from, node, to].map(|node| &self.in_cells[node]);
            sees(self.space, from, node) && sees(self.space, node, to)
        };
        let mut best = (cost_m(here), here);
        for node in others {
            let improves = |cost_m: f64| cost_m < best.0 - GAIN_M;
            // No ground is cheaper than open ground, so the length is a bound.
            if improves(self.length_m(from, node) + self.length_m(node, to))
                && improves(cost_m(node))
            {
                if !is_seen(node) {
                    break;
                }
                best = (cost_m(node), node);
            }
        }
        best.1
    }
}

/// The nodes where the direction changes, with both ends.
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

/// Whether three points follow each other on a line, up to rounding.
fn is_straight(before: &Point, here: &Point, after: &Point) -> bool {
    let (one, other) = (here - before, after - here);
    one.perp(&other).abs() <= 1e-9 * one.norm() * other.norm() && one.dot(&other) > 0.0
}
