//! What a search knows of each cell.

/// The cheapest way found to each cell, in eight bytes a cell, and in no time none of them.
///
/// A word holds, from its lowest bit up: the number of the search that wrote it, whether the cell has been expanded since
/// it was last improved, how it was reached, and the cost of reaching it. A word of an earlier search counts as
/// not written, so beginning a search touches no memory; and memory never touched costs nothing.
#[derive(Clone, Debug, Default)]
pub(super) struct Labels {
    words: Vec<u64>,
    search: u64,
}

/// How a cell was reached, as told to [`Labels::reach`]: below 16.
pub(super) type Arrival = u8;

const SEARCH_BITS: u32 = 14;
const SEARCH: u64 = (1 << SEARCH_BITS) - 1;
const EXPANDED: u64 = 1 << SEARCH_BITS;
const ARRIVAL_SHIFT: u32 = SEARCH_BITS + 1;
/// Costs have 45 bits: diagonals through 1.7 billion cells, on grids of at most a tenth of a billion.
const COST_SHIFT: u32 = ARRIVAL_SHIFT + 4;

impl Labels {
    /// Forgets all, and makes room for so many cells.
    pub fn begin(&mut self, cells: usize) {
        if self.words.len() < cells {
            // New zeros come from the system untouched; longer old ones would be copied.
            self.words = vec![0; cells];
            self.search = 0;
        }
        self.search += 1;
        if self.search > SEARCH {
            self.words.fill(0);
            self.search = 1;
        }
    }

    /// Notes a way to a cell, unless it is no cheaper than one known, or the cell has been expanded and that `settles` it.
    /// Returns whether it did.
    #[inline]
    pub fn reach(&mut self, index: usize, cost: u64, arrival: Arrival, settles: bool) -> bool {
        let word = &mut self.words[index];
        if *word & SEARCH == self.search {
            let settled = settles && *word & EXPANDED != 0;
            if settled || *word >> COST_SHIFT <= cost {
                return false;
            }
        }
        *word = cost << COST_SHIFT | u64::from(arrival) << ARRIVAL_SHIFT | self.search;
        true
    }

    /// Marks a cell that was reached as expanded; its cost and arrival, or none where it was marked already.
    #[inline]
    pub fn expand(&mut self, index: usize) -> Option<(u64, Arrival)> {
        let word = &mut self.words[index];
        if *word & EXPANDED != 0 {
            return None;
        }
        *word |= EXPANDED;
        Some((*word >> COST_SHIFT, arrival(*word)))
    }

    /// How a cell that was reached was reached.
    pub fn arrival(&self, index: usize) -> Arrival {
        arrival(self.words[index])
    }
}

#[inline]
const fn arrival(word: u64) -> Arrival {
    (word >> ARRIVAL_SHIFT & 0xf) as Arrival
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_new_search_remembers_nothing_however_many_there_were() {
        let mut labels = Labels::default();
        for search in 0..40_000 {
            labels.begin(10);
            assert!(labels.reach(3, 100 + search, 7, false), "{search}");
            assert!(!labels.reach(3, 100 + search, 8, false));
            assert_eq!(labels.expand(3), Some((100 + search, 7)));
            assert_eq!(labels.expand(3), None);
            assert!(labels.reach(3, 99, 15, false));
            assert_eq!(labels.expand(3), Some((99, 15)));
            assert!(!labels.reach(3, 98, 1, true));
        }
        labels.begin(1000);
        assert!(labels.reach(999, (1 << 45) - 1, 0, true));
        assert_eq!(labels.expand(999), Some(((1 << 45) - 1, 0)));
    }
}
