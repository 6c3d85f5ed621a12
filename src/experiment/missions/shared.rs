//! Missions that several setups reached: only over these do their times compare.

use std::collections::{BTreeMap, BTreeSet};

use super::{Ending, MissionRow};

/// A mission, whatever drives it: its map's name, and its seed.
pub(in crate::experiment) type Which<'a> = (&'a str, u64);

/// The time of each mission reached, seconds.
pub(in crate::experiment) fn times_s<'a>(rows: &[&'a MissionRow]) -> BTreeMap<Which<'a>, f64> {
    let reached = rows.iter().filter(|row| row.result == Ending::Reached);
    reached
        .map(|row| ((row.map.as_str(), row.seed), row.time_s))
        .collect()
}

/// The missions that all reached, of those that reached any.
pub(in crate::experiment) fn shared<'a, 'm>(
    times: impl IntoIterator<Item = &'m BTreeMap<Which<'a>, f64>>,
) -> BTreeSet<Which<'a>>
where
    'a: 'm,
{
    times
        .into_iter()
        .filter(|times| !times.is_empty())
        .map(|times| times.keys().copied().collect::<BTreeSet<_>>())
        .reduce(|one, other| &one & &other)
        .unwrap_or_default()
}
