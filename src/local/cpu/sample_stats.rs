//! Counts and totals of samples, accumulated in lanes and merged.

use super::lanes::Lanes;
use crate::local::engine::{Counts, Totals};
use crate::local::select;

/// Counts and totals of samples.
#[derive(Clone, Copy, Debug, Default)]
pub struct SampleStats {
    /// The number of samples of each status.
    pub counts: Counts,
    /// Sums and ranges of the terms of the admissible samples.
    pub totals: Totals,
}

impl SampleStats {
    /// Adds other statistics.
    pub fn merge(&mut self, other: &Self) {
        self.counts.admissible += other.counts.admissible;
        self.counts.collision += other.counts.collision;
        self.counts.cannot_stop += other.counts.cannot_stop;
        self.counts.outside += other.counts.outside;
        self.totals = select::merge(self.totals, other.totals);
    }
}

/// Number of vectors of terms below 2^24 for which the sums of the lanes stay below 2^32.
const VECTORS_PER_SUM: u32 = 256;

/// Index of the path term, the only term with the best value at its minimum.
const PATH: usize = 3;

/// Statistics in lanes: sums of 32 bits, flushed before they can overflow.
#[derive(Clone, Copy)]
pub struct LaneStats<L: Lanes> {
    token: L::FeatureToken,
    counts: Counts,
    flushed: [u64; 4],
    sums: [L; 4],
    min: [L; 4],
    max: [L; 4],
    vectors: u32,
    /// Best value of each term in the current row: the maximum, for the path term the minimum.
    best: [L; 4],
    /// Admissible samples of the previous rows.
    admissible_before: u32,
}

impl<L: Lanes> LaneStats<L> {
    /// Empty statistics.
    #[inline(always)]
    pub fn new(token: L::FeatureToken) -> Self {
        let zero = L::splat(token, 0);
        Self {
            token,
            counts: Counts::default(),
            flushed: [0; 4],
            sums: [zero; 4],
            min: [L::splat(token, i32::MAX); 4],
            max: [zero; 4],
            vectors: 0,
            best: Self::worst(token),
            admissible_before: 0,
        }
    }

    /// Values that every term beats.
    #[inline(always)]
    fn worst(token: L::FeatureToken) -> [L; 4] {
        let zero = L::splat(token, 0);
        [zero, zero, zero, L::splat(token, i32::MAX)]
    }

    /// Counts the samples of one vector by bit masks: existing, not admissible, colliding, off the field.
    #[inline(always)]
    pub fn count(&mut self, valid: u32, bad: u32, collision: u32, outside: u32) {
        self.counts.admissible += (valid & !bad).count_ones();
        self.counts.collision += collision.count_ones();
        self.counts.outside += outside.count_ones();
        self.counts.cannot_stop += (bad & !collision & !outside).count_ones();
    }

    /// Whether the current row has an admissible sample.
    #[inline(always)]
    pub const fn has_admissible(&self) -> bool {
        self.counts.admissible > self.admissible_before
    }

    /// Adds the terms of one vector in the lanes of `ok`.
    #[inline(always)]
    pub fn accumulate(&mut self, ok: L::Mask, terms: [L; 4]) {
        if self.vectors == VECTORS_PER_SUM {
            self.flush();
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

    /// Ends a row. Returns the best value of each term, or `None` when no sample is admissible.
    #[inline(always)]
    pub fn end_row(&mut self) -> Option<[i32; 4]> {
        if !self.has_admissible() {
            return None;
        }
        self.admissible_before = self.counts.admissible;
        let [heading, clearance, velocity, path] = self.best;
        self.max[0] = self.max[0].max(heading);
        self.max[1] = self.max[1].max(clearance);
        self.max[2] = self.max[2].max(velocity);
        self.min[PATH] = self.min[PATH].min(path);
        self.best = Self::worst(self.token);
        Some([
            heading.reduce_max(),
            clearance.reduce_max(),
            velocity.reduce_max(),
            path.reduce_min(),
        ])
    }

    #[inline(always)]
    fn flush(&mut self) {
        let mut term = 0;
        while term < 4 {
            self.flushed[term] += self.sums[term].reduce_sum_unsigned();
            self.sums[term] = L::splat(self.token, 0);
            term += 1;
        }
        self.vectors = 0;
    }

    /// The statistics of all lanes.
    #[inline(always)]
    pub fn finish(mut self) -> SampleStats {
        if self.counts.admissible == 0 {
            return SampleStats { counts: self.counts, totals: Totals::default() };
        }
        self.flush();
        let mut totals = Totals { sums: self.flushed, ..Totals::default() };
        let mut term = 0;
        while term < 4 {
            totals.min[term] = self.min[term].reduce_min() as u32;
            totals.max[term] = self.max[term].reduce_max() as u32;
            term += 1;
        }
        SampleStats { counts: self.counts, totals }
    }
}
