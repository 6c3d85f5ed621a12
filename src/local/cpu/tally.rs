//! Counts and totals of samples, in lanes and merged.

use super::lanes::Lanes;
use crate::local::contract::{Counts, Totals};
use crate::local::select;

/// What samples add up to.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tally {
    /// How many were judged how.
    pub counts: Counts,
    /// Sums and ranges of the terms of the admissible ones.
    pub totals: Totals,
}

impl Tally {
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
pub struct LaneTally<L: Lanes> {
    proof: L::Proof,
    counts: Counts,
    emptied: [u64; 4],
    sums: [L; 4],
    least: [L; 4],
    greatest: [L; 4],
    vectors: u32,
    /// Of the row under way the greatest of each term, and of the last, the path's, the least.
    best: [L; 4],
    /// Admissible samples of the rows before.
    before: u32,
}

impl<L: Lanes> LaneTally<L> {
    /// An empty one.
    #[inline(always)]
    pub fn new(proof: L::Proof) -> Self {
        let zero = L::splat(proof, 0);
        Self {
            proof,
            counts: Counts::default(),
            emptied: [0; 4],
            sums: [zero; 4],
            least: [L::splat(proof, i32::MAX); 4],
            greatest: [zero; 4],
            vectors: 0,
            best: Self::nothing(proof),
            before: 0,
        }
    }

    /// Worse than any term.
    #[inline(always)]
    fn nothing(proof: L::Proof) -> [L; 4] {
        let zero = L::splat(proof, 0);
        [zero, zero, zero, L::splat(proof, i32::MAX)]
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
                let least = self.least[term];
                self.best[term] = L::select(ok, best.max(terms[term]), best);
                self.least[term] = L::select(ok, least.min(terms[term]), least);
            } else {
                let greatest = self.greatest[term];
                self.best[term] = L::select(ok, best.min(terms[term]), best);
                self.greatest[term] = L::select(ok, greatest.max(terms[term]), greatest);
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
        self.greatest[0] = self.greatest[0].max(heading);
        self.greatest[1] = self.greatest[1].max(clearance);
        self.greatest[2] = self.greatest[2].max(velocity);
        self.least[PATH] = self.least[PATH].min(path);
        self.best = Self::nothing(self.proof);
        Some([
            heading.greatest(),
            clearance.greatest(),
            velocity.greatest(),
            path.least(),
        ])
    }

    #[inline(always)]
    fn empty(&mut self) {
        let mut term = 0;
        while term < 4 {
            self.emptied[term] += self.sums[term].total_unsigned();
            self.sums[term] = L::splat(self.proof, 0);
            term += 1;
        }
        self.vectors = 0;
    }

    /// All of it.
    #[inline(always)]
    pub fn finish(mut self) -> Tally {
        if self.counts.admissible == 0 {
            return Tally {
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
            totals.least[term] = self.least[term].least() as u32;
            totals.greatest[term] = self.greatest[term].greatest() as u32;
            term += 1;
        }
        Tally {
            counts: self.counts,
            totals,
        }
    }
}
