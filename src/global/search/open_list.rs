//! The cells that have been reached and not yet expanded, and which of them comes next.

use std::collections::BinaryHeap;

use super::node::Node;

/// An order in which to expand cells.
pub(super) trait OpenList {
    /// Whether a cell is expanded once only, though a cheaper way to it be found later.
    const SETTLES: bool;

    /// Adds a cell with its estimated total cost and the cost of reaching it.
    fn push(&mut self, estimate: u64, cost: u64, node: Node);

    /// Takes the next cell, and a bound: neither it nor any that is left has a lower estimate.
    fn pop(&mut self) -> Option<(Node, u64)>;
}

/// Buckets of nearly equal estimates, for a consistent heuristic: then no cell is added below the bucket in work, and a
/// ring of buckets as long as the largest step is enough.
///
/// Within a bucket the cell added last comes first, whatever its estimate. So a cell may be expanded before the
/// cheapest way to it is known; it is expanded again then, and the search ends only when no estimate left can be below
/// the goal's cost. That is rare, and much cheaper than keeping order.
#[derive(Clone, Debug, Default)]
pub(super) struct Buckets {
    /// The first cell of each bucket's list, as a place in `entries` plus one; zero where empty.
    heads: Vec<u32>,
    /// A bit for each bucket that is not empty.
    filled: Vec<u64>,
    entries: Vec<Entry>,
    /// First of the list of entries to be used again, plus one.
    spare: u32,
    /// The estimate at which bucket zero began.
    base: u64,
    /// The bucket in work, counted from `base`, not from where the ring begins.
    current: u64,
}

#[derive(Clone, Copy, Debug)]
struct Entry {
    node: Node,
    next: u32,
}

/// A bucket spans this many units of cost as a power of two: 0.3 cells. With an octile estimate the smallest step
/// between two estimates that differ is 0.59 cells.
const WIDTH_SHIFT: u32 = 12;

impl Buckets {
    /// Empties the list for a search whose estimates begin at `base` and grow by at most `largest_step` from one cell to
    /// the next.
    pub fn begin(&mut self, base: u64, largest_step: u64) {
        let count = ((largest_step >> WIDTH_SHIFT) as usize + 2)
            .next_power_of_two()
            .max(64);
        for (word, bits) in self.filled.iter_mut().enumerate() {
            while *bits != 0 {
                self.heads[word * 64 + bits.trailing_zeros() as usize] = 0;
                *bits &= *bits - 1;
            }
        }
        self.heads.resize(count, 0);
        self.filled.resize(count / 64, 0);
        self.entries.clear();
        self.spare = 0;
        self.base = base;
        self.current = 0;
    }

    /// The first bucket from the current one on that is not empty, counted from `base`.
    fn first_filled(&self) -> Option<u64> {
        let mask = self.filled.len() - 1;
        let (word, bit) = ((self.current / 64) as usize, self.current % 64);
        let ahead = self.filled[word & mask] >> bit;
        if ahead != 0 {
            return Some(self.current + u64::from(ahead.trailing_zeros()));
        }
        // The ring's last word is that of the current bucket again: the part before it.
        (1..=self.filled.len()).find_map(|further| {
            let bits = self.filled[(word + further) & mask];
            let bucket = (word + further) as u64 * 64 + u64::from(bits.trailing_zeros());
            (bits != 0).then_some(bucket)
        })
    }
}

impl OpenList for Buckets {
    const SETTLES: bool = false;

    #[inline]
    fn push(&mut self, estimate: u64, _cost: u64, node: Node) {
        let bucket = (estimate - self.base) >> WIDTH_SHIFT;
        debug_assert!(bucket >= self.current && bucket - self.current < self.heads.len() as u64);
        let bucket = bucket as usize & (self.heads.len() - 1);
        let entry = Entry {
            node,
            next: self.heads[bucket],
        };
        let place = if self.spare == 0 {
            self.entries.push(entry);
            self.entries.len() as u32
        } else {
            let place = self.spare;
            let used = &mut self.entries[place as usize - 1];
            self.spare = used.next;
            *used = entry;
            place
        };
        self.heads[bucket] = place;
        self.filled[bucket / 64] |= 1 << (bucket % 64);
    }

    #[inline]
    fn pop(&mut self) -> Option<(Node, u64)> {
        self.current = self.first_filled()?;
        let bucket = self.current as usize & (self.heads.len() - 1);
        let place = self.heads[bucket];
        let entry = &mut self.entries[place as usize - 1];
        let node = entry.node;
        self.heads[bucket] = entry.next;
        if entry.next == 0 {
            self.filled[bucket / 64] &= !(1 << (bucket % 64));
        }
        entry.next = self.spare;
        self.spare = place;
        Some((node, self.base + (self.current << WIDTH_SHIFT)))
    }
}

/// Textbook order, for any heuristic: of equal estimates the cell that cost more to reach comes first,
/// then the one stored first. No cell is expanded twice: a heuristic that overestimates would pay up to
/// ten times the expansions for little, and no other gains by it.
#[derive(Clone, Debug, Default)]
pub(super) struct Sorted {
    /// The greatest comes first: the estimate upside down, the cost and the cell upside down.
    keys: BinaryHeap<u128>,
}

/// Estimates have 48 bits: heuristics stop well below that, and costs have 45.
const MOST_ESTIMATE: u64 = (1 << 48) - 1;

impl Sorted {
    /// Empties the list.
    pub fn begin(&mut self) {
        self.keys.clear();
    }
}

impl OpenList for Sorted {
    const SETTLES: bool = true;

    #[inline]
    fn push(&mut self, estimate: u64, cost: u64, node: Node) {
        let estimate = MOST_ESTIMATE - estimate;
        let key = u128::from(estimate) << 80 | u128::from(cost) << 32 | u128::from(!node.bits());
        self.keys.push(key);
    }

    #[inline]
    fn pop(&mut self) -> Option<(Node, u64)> {
        let key = self.keys.pop()?;
        Some((
            Node::from_bits(!(key as u32)),
            MOST_ESTIMATE - (key >> 80) as u64,
        ))
    }
}
