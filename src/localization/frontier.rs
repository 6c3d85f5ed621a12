//! The nodes that a branch and bound search has not divided yet, in the order of their bounds.

/// A block of 2^level x 2^level translations at one yaw. Smaller blocks come first, and others in a fixed order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Node {
    pub level: u8,
    pub turn: u16,
    /// Column and row at which it begins.
    pub right: u16,
    pub up: u16,
}

/// Nodes by their bounds, which are small integers: one list for each is much faster than a heap of all nodes.
#[derive(Clone, Debug)]
pub(super) struct Frontier {
    nodes: Vec<Vec<Node>>,
    /// The highest bound or more.
    top: usize,
    /// Whether the nodes of this bound are in order, the first one last. A list is sorted when a node is taken from it.
    is_sorted: bool,
}

impl Frontier {
    /// Creates an empty frontier. No bound may be above `highest`.
    pub fn new(highest: u32) -> Self {
        Self { nodes: vec![Vec::new(); highest as usize + 1], top: 0, is_sorted: false }
    }

    pub fn push(&mut self, bound: u32, node: Node) {
        let bound = bound as usize;
        if bound > self.top {
            (self.top, self.is_sorted) = (bound, false);
        }
        let nodes = &mut self.nodes[bound];
        if bound == self.top && self.is_sorted {
            let at = nodes.partition_point(|other| *other > node);
            nodes.insert(at, node);
        } else {
            nodes.push(node);
        }
    }

    /// Takes the node with the highest bound, and the first of these.
    pub fn pop(&mut self) -> Option<(u32, Node)> {
        while self.nodes[self.top].is_empty() {
            (self.top, self.is_sorted) = (self.top.checked_sub(1)?, false);
        }
        let nodes = &mut self.nodes[self.top];
        if !self.is_sorted {
            nodes.sort_unstable_by(|one, other| other.cmp(one));
            self.is_sorted = true;
        }
        nodes.pop().map(|node| (self.top as u32, node))
    }

    pub fn clear(&mut self) {
        self.nodes.iter_mut().for_each(Vec::clear);
    }
}

#[cfg(test)]
mod tests {
    use core::cmp::Reverse;
    use std::collections::BinaryHeap;

    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    use super::*;

    #[test]
    fn nodes_come_as_from_a_heap() {
        let mut random = Pcg64Mcg::seed_from_u64(3);
        let (mut frontier, mut heap) = (Frontier::new(40), BinaryHeap::new());
        for step in 0..20_000 {
            let pushes = if step < 10_000 { 0..random.random_range(0..4) } else { 0..0 };
            for _ in pushes {
                let mut below = |most: u16| random.random_range(0..most);
                let node =
                    Node { level: below(3) as u8, turn: below(3), right: below(4), up: below(4) };
                let bound = u32::from(below(41));
                frontier.push(bound, node);
                heap.push((bound, Reverse(node)));
            }
            let expected = heap.pop().map(|(bound, Reverse(node))| (bound, node));
            assert_eq!(frontier.pop(), expected, "step {step}");
        }
    }
}
