//! Counts and totals of samples, in lanes and merged.

use super::lanes::Lanes;
use crate::local::engine::{Counts, Totals};
use crate::local::select;

/// What samples add up to.
#[derive(Clone, Copy, Debug, Default)]
pub struct SampleStats {
    /// How many were judged how.
    pub counts: Counts,
    /// Sums and ranges of the terms of the admissible ones.
    pub totals: Totals,
}

impl SampleStats {
    /// Adds another.
    pub fn merge(&mut self, other: &Self) {
        self.counts.admissible += other.counts.admissible;
        self.counts.collision += other.counts.collision;
        self.counts.cannot_stop += other.counts.cannot_stop;
        self.counts.outside += other.counts.outside;
        self.totals = select::merge(self.totals, other.totals);
    }
}

/// Vectors of terms below 2^24 whose lanes' sums stay below 2^32.
const VECTORS_PER_SUM: u32 = 256;

/// The term of which less is better, the last one.
const PATH: usize = 3;

/// A tally being taken: sums in lanes of 32 bits, emptied before they can overflow.
#[derive(Clone, Copy)]
pub struct LaneStats<L: Lanes> {
    token: L::FeatureToken,
    counts: Counts,
    emptied: [u64; 4],
    sums: [L; 4],
    min: [L; 4],
    max: [L; 4],
    vectors: u32,
    /// Of the row under way the greatest of each term, and of the last, the path's, the least.
    best: [L; 4],
    /// Admissible samples of the rows before.
    before: u32,
}

impl<L: Lanes> LaneStats<L> {
    /// An empty one.
    #[inline(always)]
    pub fn new(token: L::FeatureToken) -> Self {
        let zero = L::splat(token, 0);
        Self {
            token,
            counts: Counts::default(),
            emptied: [0; 4],
            sums: [zero; 4],
            min: [L::splat(token, i32::MAX); 4],
            max: [zero; 4],
            vectors: 0,
            best: Self::nothing(token),
            before: 0,
        }
    }

    /// Worse than any term.
    #[inline(always)]
    fn nothing(token: L::FeatureToken) -> [L; 4] {
        let zero = L::splat(token, 0);
        [zero, zero, zero, L::splat(token, i32::MAX)]
    }

    /// Counts the samples of one vector: bits of those there are, not admissible, collided, and off the field.
    #[inline(always)]
    pub fn count(&mut self, valid: u32, bad: u32, collision: u32, outside: u32) {
        self.counts.admissible += (valid & !bad).count_ones();
        self.counts.collision += collision.count_ones();
        self.counts.outside += outside.count_ones();
        self.counts.cannot_stop += (bad & !collision & !outside).count_ones();
    }

    /// Whether any sample of the row under way is admissible.
    #[inline(always)]
    pub const fn has_admissible(&self) -> bool {
        self.counts.admissible > self.before
    }

    /// Adds the terms of one vector where `ok` is set.
    #[inline(always)]
    pub fn gather(&mut self, ok: L::Mask, terms: [L; 4]) {
        if self.vectors == VECTORS_PER_SUM {
            self.empty();
        }
        self.vectors += 1;
        let mut term = 0;
        while term < 4 {
            let (sum, best) = (self.sums[term], self.best[term]);
            self.sums[term] = L::select(ok, sum.add(terms[term]), sum);
            if term < PATH {
                let min = self.min[term];
                self.best[term] = L::select(ok, best.max(terms[term]), best);
                self.min[term] = L::select(ok, min.min(terms[term]), min);
            } else {
                let max = self.max[term];
                self.best[term] = L::select(ok, best.min(terms[term]), best);
                self.max[term] = L::select(ok, max.max(terms[term]), max);
            }
            term += 1;
        }
    }

    /// Ends a row: the best value of each term in it, unless no sample is admissible.
    #[inline(always)]
    pub fn end_row(&mut self) -> Option<[i32; 4]> {
        if !self.has_admissible() {
            return None;
        }
        self.before = self.counts.admissible;
        let [heading, clearance, velocity, path] = self.best;
        self.max[0] = self.max[0].max(heading);
        self.max[1] = self.max[1].max(clearance);
        self.max[2] = self.max[2].max(velocity);
        self.min[PATH] = self.min[PATH].min(path);
        self.best = Self::nothing(self.token);
        Some([
            heading.reduce_max(),
            clearance.reduce_max(),
            velocity.reduce_max(),
            path.reduce_min(),
        ])
    }

    #[inline(always)]
    fn empty(&mut self) {
        let mut term = 0;
        while term < 4 {
            self.emptied[term] += self.sums[term].reduce_sum_unsigned();
            self.sums[term] = L::splat(self.token, 0);
            term += 1;
        }
        self.vectors = 0;
    }

    /// All of it.
    #[inline(always)]
    pub fn finish(mut self) -> SampleStats {
        if self.counts.admissible == 0 {
            return SampleStats {
                counts: self.counts,
                totals: Totals::default(),
            };
        }
        self.empty();
        let mut totals = Totals {
            sums: self.emptied,
            ..Totals::default()
        };
        let mut term = 0;
        while term < 4 {
            totals.min[term] = self.min[term].reduce_min() as u32;
            totals.max[term] = self.max[term].reduce_max() as u32;
            term += 1;
        }
        SampleStats {
            counts: self.counts,
            totals,
        }
    }
}
