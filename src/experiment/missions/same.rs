//! The same missions again on another engine: whether the traces are the same to the last bit.

use serde::Serialize;

use super::{MissionKey, MissionRow};
use crate::experiment::campaign::Row;

/// A mission driven on two engines.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Name of the map.
    pub map: String,
    /// Seed of the mission.
    pub seed: u64,
    /// The other engine.
    pub engine: String,
    /// The engine of the row.
    pub first: String,
    /// Digest of the row's trace.
    pub expected: Option<String>,
    /// Digest of the other's.
    pub found: Option<String>,
    /// Whether they are equal.
    pub equal: bool,
}

/// Compares the rows of missions with those of the same missions on another engine. A row without a sibling is left out.
#[must_use]
pub fn compare_digests(rows: &[&MissionRow], again: &[MissionRow]) -> Vec<Comparison> {
    let sibling = |key: &MissionKey| rows.iter().find(|row| row.key() == *key);
    let compared = again.iter().filter_map(|other| {
        let row = sibling(&other.key())?;
        Some(Comparison {
            map: row.map.clone(),
            seed: row.seed,
            engine: other.engine.clone(),
            first: row.engine.clone(),
            expected: row.trace_digest.clone(),
            found: other.trace_digest.clone(),
            equal: row.trace_digest == other.trace_digest,
        })
    });
    compared.collect()
}

/// So many of a list, evenly spread over it, or all.
#[must_use]
pub fn spread_evenly<T: Clone>(all: &[T], wanted: usize) -> Vec<T> {
    let wanted = wanted.min(all.len());
    (0..wanted)
        .map(|index| all[index * all.len() / wanted].clone())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spread_is_even_and_never_more_than_all() {
        let all: Vec<u32> = (0..10).collect();
        assert_eq!(spread_evenly(&all, 5), [0, 2, 4, 6, 8]);
        assert_eq!(spread_evenly(&all, 3), [0, 3, 6]);
        assert_eq!(spread_evenly(&all, 99), all);
        assert!(spread_evenly(&all, 0).is_empty());
    }
}
