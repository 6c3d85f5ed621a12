//! Compares the traces of the same runs on two engines, bit for bit.

use serde::Serialize;

use super::RunRow;

/// A run driven on two engines.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Name of the world.
    pub world: String,
    /// The seed.
    pub seed: u64,
    /// The other engine.
    pub engine: Option<String>,
    /// The engine of the first run.
    pub first: Option<String>,
    /// Trace digest of the first run.
    pub expected: Option<String>,
    /// Trace digest of the other run.
    pub found: Option<String>,
    /// Whether the digests are equal.
    pub equal: bool,
}

/// Compares runs with the same runs on another engine. A run without a counterpart is left out.
#[must_use]
pub fn compare_digests(rows: &[RunRow], others: &[RunRow]) -> Vec<Comparison> {
    let compared = others.iter().filter_map(|other| {
        let is_same = |row: &&RunRow| {
            (&row.config, &row.world, row.seed) == (&other.config, &other.world, other.seed)
        };
        let row = rows.iter().find(is_same)?;
        Some(Comparison {
            world: row.world.clone(),
            seed: row.seed,
            engine: other.ran_on.clone(),
            first: row.ran_on.clone(),
            expected: row.trace_digest.clone(),
            found: other.trace_digest.clone(),
            equal: row.trace_digest == other.trace_digest,
        })
    });
    compared.collect()
}

/// Returns this many elements spread evenly over a list, or all of them.
#[must_use]
pub fn spread_evenly<T: Clone>(all: &[T], wanted: usize) -> Vec<T> {
    let wanted = wanted.min(all.len());
    (0..wanted).map(|index| all[index * all.len() / wanted].clone()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spread_evenly_returns_at_most_all_elements() {
        let all: Vec<u32> = (0..10).collect();
        assert_eq!(spread_evenly(&all, 5), [0, 2, 4, 6, 8]);
        assert_eq!(spread_evenly(&all, 3), [0, 3, 6]);
        assert_eq!(spread_evenly(&all, 99), all);
        assert!(spread_evenly(&all, 0).is_empty());
    }
}
