//! Per-cell state of a search.

/// The cheapest path found to each cell, in eight bytes per cell, cleared in constant time.
///
/// A word holds, from its lowest bit: the number of the search that wrote it, whether the cell has been expanded since its
/// last improvement, how it was reached, and the cost. A word with another search number counts as unwritten, so starting
/// a search writes no memory, and pages that were never touched are not allocated.
#[derive(Clone, Debug, Default)]
pub(super) struct Labels {
    words: Vec<u64>,
    search: u64,
}

/// How a cell was reached: the index of the move, or [`START`](super::astar::START); below 16.
pub(super) type Arrival = u8;

const SEARCH_BITS: u32 = 14;
const SEARCH: u64 = (1 << SEARCH_BITS) - 1;
const EXPANDED: u64 = 1 << SEARCH_BITS;
const ARRIVAL_SHIFT: u32 = SEARCH_BITS + 1;
/// Costs have 45 bits: enough for diagonals through 1.7 billion cells, on grids of at most 100 million.
const COST_SHIFT: u32 = ARRIVAL_SHIFT + 4;

impl Labels {
    /// Starts a new search on a grid of `cells` cells.
    pub fn begin(&mut self, cells: usize) {
        if self.words.len() < cells {
            // Fresh zeroed memory is not touched; resizing would copy the old words.
            self.words = vec![0; cells];
            self.search = 0;
        }
        self.search += 1;
        if self.search > SEARCH {
            self.words.fill(0);
            self.search = 1;
        }
    }

    /// Records a path to a cell and returns true, unless a path as cheap is known, or the cell has been expanded and `settles`
    /// is set.
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

    /// Marks a reached cell as expanded and returns its cost and arrival; none if it was already marked.
    #[inline]
    pub fn expand(&mut self, index: usize) -> Option<(u64, Arrival)> {
        let word = &mut self.words[index];
        if *word & EXPANDED != 0 {
            return None;
        }
        *word |= EXPANDED;
        Some((*word >> COST_SHIFT, arrival(*word)))
    }

    /// How a reached cell was reached.
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
    fn labels_are_empty_after_any_number_of_searches() {
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
