//! Totals over the admissible samples, and the selection of the best. TWIN of `shaders/select.wgsl`.

use super::engine::{Counts, SampleStatus, Totals};

/// Counts the status of one sample.
pub fn count(counts: &mut Counts, status: SampleStatus) {
    match status {
        SampleStatus::Ok => counts.admissible += 1,
        SampleStatus::Collision => counts.collision += 1,
        SampleStatus::CannotStop => counts.cannot_stop += 1,
        SampleStatus::Outside => counts.outside += 1,
    }
}

/// Adds the terms of an admissible sample to the totals.
pub fn accumulate(totals: &mut Totals, terms: [u32; 4]) {
    for (term, value) in terms.into_iter().enumerate() {
        totals.sums[term] += u64::from(value);
        totals.min[term] = totals.min[term].min(value);
        totals.max[term] = totals.max[term].max(value);
    }
}

/// Merges the totals of two sets of samples.
#[must_use]
pub fn merge(one: Totals, other: Totals) -> Totals {
    Totals {
        sums: core::array::from_fn(|term| one.sums[term] + other.sums[term]),
        min: core::array::from_fn(|term| one.min[term].min(other.min[term])),
        max: core::array::from_fn(|term| one.max[term].max(other.max[term])),
    }
}

/// Score and index of a sample.
pub type Candidate = (i64, u32);

/// Loses to every admissible sample.
pub const NO_CANDIDATE: Candidate = (i64::MIN, u32::MAX);

/// The better of two candidates: the larger score; of equal scores the lower index.
#[must_use]
pub fn better(one: Candidate, other: Candidate) -> Candidate {
    let other_wins = other.0 > one.0 || (other.0 == one.0 && other.1 < one.1);
    if other_wins { other } else { one }
}
