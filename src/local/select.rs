//! Totals over the admissible samples, and the best of them. TWIN of `shaders/select.wgsl`.

use super::contract::{Counts, Reason, Totals};

/// Adds a sample's reason to the counts.
pub fn count(counts: &mut Counts, reason: Reason) {
    match reason {
        Reason::Ok => counts.admissible += 1,
        Reason::Collision => counts.collision += 1,
        Reason::CannotStop => counts.cannot_stop += 1,
        Reason::Outside => counts.outside += 1,
    }
}

/// Adds an admissible sample's terms to the totals.
pub fn gather(totals: &mut Totals, terms: [u32; 4]) {
    for (term, value) in terms.into_iter().enumerate() {
        totals.sums[term] += u64::from(value);
        totals.least[term] = totals.least[term].min(value);
        totals.greatest[term] = totals.greatest[term].max(value);
    }
}

/// The totals of two sets of samples together.
#[must_use]
pub fn merge(one: Totals, other: Totals) -> Totals {
    Totals {
        sums: core::array::from_fn(|term| one.sums[term] + other.sums[term]),
        least: core::array::from_fn(|term| one.least[term].min(other.least[term])),
        greatest: core::array::from_fn(|term| one.greatest[term].max(other.greatest[term])),
    }
}

/// A sample in the running: score and index.
pub type Candidate = (i64, u32);

/// Loses to every admissible sample.
pub const NOBODY: Candidate = (i64::MIN, u32::MAX);

/// The better of two: the larger score, and of equal scores the lower index.
#[must_use]
pub fn better(one: Candidate, other: Candidate) -> Candidate {
    let other_wins = other.0 > one.0 || (other.0 == one.0 && other.1 < one.1);
    if other_wins { other } else { one }
}
