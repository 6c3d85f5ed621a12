//! A part of the cells, for one machine of several.

use core::str::FromStr;

use super::{Cell, SweepError};

/// Most shards.
const MOST: usize = 1_000_000;

/// Part `index`, from 1, of `count`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    index: usize,
    count: usize,
}

impl FromStr for Shard {
    type Err = SweepError;

    fn from_str(text: &str) -> Result<Self, SweepError> {
        let parts = text.split_once('/').and_then(|(index, count)| {
            let (index, count) = (index.parse().ok()?, count.parse().ok()?);
            Some(Self { index, count })
        });
        parts
            .filter(|shard| (1..=shard.count).contains(&shard.index) && shard.count <= MOST)
            .ok_or_else(|| SweepError::BadShard {
                text: text.escape_debug().to_string(),
            })
    }
}

impl Shard {
    /// The cells of this part: each is in one part, and no part has more than one cell more than another, neither of those
    /// that need a machine for themselves nor of the others. The order of the keys decides, not that of the plan, so that a
    /// part is a fair mixture of easy and hard cells.
    #[must_use]
    pub fn of<'c>(&self, cells: &[&'c Cell]) -> Vec<&'c Cell> {
        let mut all = Vec::new();
        for latency in [false, true] {
            let kind = cells.iter().filter(|cell| cell.label.latency == latency);
            let mut kind: Vec<&Cell> = kind.copied().collect();
            kind.sort_by(|one, other| one.key.cmp(&other.key));
            all.extend(kind.into_iter().skip(self.index - 1).step_by(self.count));
        }
        all
    }
}
