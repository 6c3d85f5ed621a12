//! A part of the cells, for one machine of several.

use core::str::FromStr;

use super::{Cell, ExperimentError};

/// Largest number of shards.
const MAX_SHARDS: usize = 1_000_000;

/// Part `index`, from 1, of `count`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    index: usize,
    count: usize,
}

impl FromStr for Shard {
    type Err = ExperimentError;

    fn from_str(text: &str) -> Result<Self, ExperimentError> {
        let parts = text.split_once('/').and_then(|(index, count)| {
            let (index, count) = (index.parse().ok()?, count.parse().ok()?);
            Some(Self { index, count })
        });
        parts
            .filter(|shard| (1..=shard.count).contains(&shard.index) && shard.count <= MAX_SHARDS)
            .ok_or_else(|| ExperimentError::BadShard { text: text.escape_debug().to_string() })
    }
}

impl Shard {
    /// The cells of this part. Each cell is in one part. The numbers of latency cells differ by at most one between parts, and
    /// so do the numbers of other cells. The keys determine the part, not the plan's order: a part mixes easy and hard cells.
    #[must_use]
    pub fn of<'c>(&self, cells: &[&'c Cell]) -> Vec<&'c Cell> {
        let mut all = Vec::new();
        for latency in [false, true] {
            let kind = cells.iter().filter(|cell| cell.id.latency == latency);
            let mut kind: Vec<&Cell> = kind.copied().collect();
            kind.sort_by(|one, other| one.key.cmp(&other.key));
            all.extend(kind.into_iter().skip(self.index - 1).step_by(self.count));
        }
        all
    }
}
