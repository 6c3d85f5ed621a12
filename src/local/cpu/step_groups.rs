//! Lists of groups of steps in fixed memory.

use super::lanes::{Lanes, MAX_LANES};
use super::soa_inputs::GROUPS;

/// Some groups of steps, with space for one more vector store.
#[derive(Clone, Debug)]
pub struct StepGroups {
    list: [i32; GROUPS + MAX_LANES],
    count: usize,
}

impl Default for StepGroups {
    fn default() -> Self {
        Self { list: [0; GROUPS + MAX_LANES], count: 0 }
    }
}

impl StepGroups {
    /// Removes all groups.
    #[inline(always)]
    pub const fn clear(&mut self) {
        self.count = 0;
    }

    /// Adds one group; there are never more than [`GROUPS`].
    #[inline(always)]
    pub const fn push(&mut self, group: i32) {
        self.list[self.count] = group;
        self.count += 1;
    }

    /// Adds the groups in the lanes of a mask.
    #[inline(always)]
    pub fn add<L: Lanes>(&mut self, set: L::Mask, groups: L) {
        self.count += L::compress(set, groups, &mut self.list[self.count..]);
    }

    /// The groups, in the order in which they were added.
    #[inline(always)]
    pub fn as_slice(&self) -> &[i32] {
        &self.list[..self.count]
    }
}
