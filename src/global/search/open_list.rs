//! Open lists: the cells reached and not yet expanded, in the order of expansion.

use std::collections::BinaryHeap;

use super::moves::Node;

/// A priority queue of cells.
pub(super) trait OpenList {
    /// Whether a cell is expanded only once, even if a cheaper path to it is found later.
    const SETTLES: bool;

    /// Adds a cell with its estimated total cost and the cost so far.
    fn push(&mut self, estimate: u64, cost: u64, node: Node);

    /// Removes the next cell. The second value is a lower bound of its estimate and of all remaining ones.
    fn pop(&mut self) -> Option<(Node, u64)>;
}

/// A bucket queue for a consistent heuristic: no cell is added below the current bucket, so a ring as long as the largest
/// step is sufficient.
///
/// Buckets are last-in first-out, whatever the estimate. A cell may therefore be expanded before its cheapest path is known
/// and is then expanded again; the search ends only if no remaining estimate can be below the goal's cost. This is rare, and
/// much cheaper than a full order.
#[derive(Clone, Debug, Default)]
pub(super) struct Buckets {
    /// The first entry of each bucket, as its index in `entries` plus one; zero if empty.
    heads: Vec<u32>,
    /// A bit for each non-empty bucket.
    filled: Vec<u64>,
    entries: Vec<Entry>,
    /// The first free entry, as its index plus one.
    spare: u32,
    /// The estimate at the start of bucket zero.
    base: u64,
    /// The current bucket, counted from `base`, not from the start of the ring.
    current: u64,
}

#[derive(Clone, Copy, Debug)]
struct Entry {
    node: Node,
    next: u32,
}

/// Width of a bucket in units of cost, as a power of two: 0.3 cells. The smallest difference of two octile estimates is 0.59
/// cells.
const WIDTH_SHIFT: u32 = 12;

impl Buckets {
    /// Clears the list for a search whose estimates start at `base` and grow by at most `largest_step` per move.
    pub fn begin(&mut self, base: u64, largest_step: u64) {
        let count = ((largest_step >> WIDTH_SHIFT) as usize + 2).next_power_of_two().max(64);
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

    /// The first non-empty bucket from the current one on, counted from `base`.
    fn first_filled(&self) -> Option<u64> {
        let mask = self.filled.len() - 1;
        let (word, bit) = ((self.current / 64) as usize, self.current % 64);
        let ahead = self.filled[word & mask] >> bit;
        if ahead != 0 {
            return Some(self.current + u64::from(ahead.trailing_zeros()));
        }
        // The last word of the ring is the current word again: the buckets before the current one.
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
        let entry = Entry { node, next: self.heads[bucket] };
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

/// A binary heap in textbook order, for any heuristic: by estimate, ties by higher cost so far, then by storage order. No cell
/// is expanded twice: repeated expansions would cost an overestimating heuristic up to ten times the expansions for little
/// gain.
#[derive(Clone, Debug, Default)]
pub(super) struct Sorted {
    /// Max-heap keys: complement of the estimate, the cost, complement of the cell.
    keys: BinaryHeap<u128>,
}

/// Largest estimate: 48 bits. Heuristics are limited well below, and costs have 45 bits.
const MAX_ESTIMATE: u64 = (1 << 48) - 1;

impl Sorted {
    /// Clears the list.
    pub fn begin(&mut self) {
        self.keys.clear();
    }
}

impl OpenList for Sorted {
    const SETTLES: bool = true;

    #[inline]
    fn push(&mut self, estimate: u64, cost: u64, node: Node) {
        let estimate = MAX_ESTIMATE - estimate;
        let key = u128::from(estimate) << 80 | u128::from(cost) << 32 | u128::from(!node.bits());
        self.keys.push(key);
    }

    #[inline]
    fn pop(&mut self) -> Option<(Node, u64)> {
        let key = self.keys.pop()?;
        Some((Node::from_bits(!(key as u32)), MAX_ESTIMATE - (key >> 80) as u64))
    }
}
