//! One row of the field: the lowest of the parabolas `(x - site)^2 + height(site)^2` at each column.
//!
//! The lowest site never moves left as the column increases, so the lowest sites of two columns bound those of all
//! columns between them. The lowest site of every sixteenth column is found by bisection. All sites between two of these
//! are then compared at the sixteen columns between, sixteen at once: about seventeen comparisons per column, vectorised
//! and without data-dependent branches. A stack-based envelope mispredicts at every other column of rough terrain.

use multiversion::multiversion;

use super::FAR;
use super::lane::Lane;

/// Columns compared at once.
const BLOCK: usize = 16;
/// Sites compared at once.
const SITES: usize = 8;
/// Above this width, the column indices including the padding do not fit in `u16`.
const WIDEST: usize = 65_000;

/// Upper bounds of the distance to the nearest obstacle, in cells, in the most recently computed row: for the first column
/// of each block and for the last column. The bound for the next row is at most one larger.
pub(super) struct Reach(Vec<usize>);

impl Reach {
    /// The bounds before the first row.
    pub(super) fn unknown(width: usize) -> Self {
        Self(vec![usize::from(FAR); width.div_ceil(BLOCK) + 1])
    }

    /// Whether `u16` is sufficient for the next row. Distances at the known columns are then at most 214 cells, so those
    /// between are at most 222, and sites are at most 230 columns from the columns where they are compared. Both are
    /// below 255, at which `u16` saturates.
    pub(super) fn is_near(&self, width: usize) -> bool {
        width <= WIDEST && self.0.iter().all(|&reach| reach < 214)
    }
}

/// Working memory for one row, padded to a whole last block and a whole last group of sites.
pub(super) struct Row<T> {
    columns: Vec<T>,
    squared_heights: Vec<T>,
    /// The lowest site at the columns of [`Reach`].
    nearest: Vec<usize>,
    lowest: Vec<[T; BLOCK]>,
}

impl<T: Lane> Row<T> {
    pub(super) fn new(width: usize) -> Self {
        let blocks = width.div_ceil(BLOCK);
        let padded = blocks * BLOCK + SITES;
        Self {
            columns: (0..padded).map(T::column).collect(),
            squared_heights: vec![T::square_of_height(FAR); padded],
            nearest: vec![0; blocks + 1],
            lowest: vec![[T::MOST; BLOCK]; blocks],
        }
    }

    /// Writes the squared distances of a row from its column heights. At least one height is not [`FAR`].
    #[inline(always)]
    fn lower(&mut self, heights: &[u16], reach: &mut Reach, squared: &mut [u32]) {
        for (square, &height) in self.squared_heights.iter_mut().zip(heights) {
            *square = T::square_of_height(height);
        }
        self.find_nearest(heights, &mut reach.0);
        self.fill_blocks(heights);
        for (whole, lowest) in squared.iter_mut().zip(self.lowest.as_flattened()) {
            *whole = lowest.whole();
        }
    }

    /// Finds the lowest sites at the block ends: the outermost first, then by bisection.
    #[inline(always)]
    fn find_nearest(&mut self, heights: &[u16], reach: &mut [usize]) {
        let (last_end, last_column) = (self.nearest.len() - 1, heights.len() - 1);
        for end in [0, last_end] {
            self.find_nearest_at(end, (0, last_column), heights, reach);
        }
        let mut stride = last_end.next_power_of_two();
        while stride > 1 {
            let half = stride / 2;
            for end in (half..last_end).step_by(stride) {
                let between = (self.nearest[end - half], self.nearest[(end + half).min(last_end)]);
                self.find_nearest_at(end, between, heights, reach);
            }
            stride = half;
        }
    }

    #[inline(always)]
    fn find_nearest_at(
        &mut self,
        end: usize,
        (first, last): (usize, usize),
        heights: &[u16],
        reach: &mut [usize],
    ) {
        let column = (end * BLOCK).min(heights.len() - 1);
        // The obstacle of the column itself bounds the distance.
        let within = (reach[end] + 1).min(usize::from(heights[column]));
        let first = first.max(column.saturating_sub(within));
        let last = last.min(column + within);
        // Whole groups: a few extra sites do not change the minimum.
        let sites = first..first + (last - first) / SITES * SITES + SITES;
        let (columns, _) = self.columns[sites.clone()].as_chunks::<SITES>();
        let (squares, _) = self.squared_heights[sites].as_chunks::<SITES>();
        let x = self.columns[column];
        let (mut lowest, mut at) = ([T::MOST; SITES], [self.columns[first]; SITES]);
        for (sites, squares) in columns.iter().zip(squares) {
            for lane in 0..SITES {
                let value = T::parabola(x.minus(sites[lane]), squares[lane]);
                let lower = value < lowest[lane];
                lowest[lane] = if lower { value } else { lowest[lane] };
                at[lane] = if lower { sites[lane] } else { at[lane] };
            }
        }
        let mut best = (lowest[0], at[0]);
        for lane in 1..SITES {
            let lower = lowest[lane] < best.0;
            best.0 = if lower { lowest[lane] } else { best.0 };
            best.1 = if lower { at[lane] } else { best.1 };
        }
        self.nearest[end] = best.1.whole() as usize;
        reach[end] = f64::from(best.0.whole()).sqrt() as usize + 1;
    }

    #[inline(always)]
    fn fill_blocks(&mut self, heights: &[u16]) {
        let (blocks, _) = self.columns.as_chunks::<BLOCK>();
        for (block, (columns, out)) in blocks.iter().zip(&mut self.lowest).enumerate() {
            let start = block * BLOCK;
            // Large parts of a map are solid.
            let inside = heights.get(start..start + BLOCK);
            if inside.is_some_and(|heights| heights.iter().fold(0, |all, height| all | height) == 0)
            {
                *out = [T::square_of_height(0); BLOCK];
                continue;
            }
            let (first, last) = (self.nearest[block], self.nearest[block + 1]);
            *out = lowest_of(
                columns,
                &self.columns[first..],
                &self.squared_heights[first..],
                self.columns[last],
            );
        }
    }
}

/// Calls [`Row::lower`] compiled for the widest vectors of the processor.
#[multiversion(targets("x86_64+avx2"))]
pub(super) fn lower<T: Lane>(
    row: &mut Row<T>,
    heights: &[u16],
    reach: &mut Reach,
    squared: &mut [u32],
) {
    row.lower(heights, reach, squared);
}

/// The lowest values at these columns of the parabolas of adjacent sites, up to and including `last`.
///
/// The loop checks the end at each site on purpose. With a known trip count the compiler vectorises over sites instead of
/// columns, which takes three times as long.
#[inline(always)]
fn lowest_of<T: Lane>(
    columns: &[T; BLOCK],
    sites: &[T],
    squared_heights: &[T],
    last: T,
) -> [T; BLOCK] {
    let mut lowest = [T::MOST; BLOCK];
    let mut offsets = columns.map(|column| column.minus(sites[0]));
    for (&site, &squared_height) in sites.iter().zip(squared_heights) {
        if site > last {
            break;
        }
        for (lowest, offset) in lowest.iter_mut().zip(&mut offsets) {
            let value = T::parabola(*offset, squared_height);
            *lowest = if value < *lowest { value } else { *lowest };
            // The next site is one column to the right.
            *offset = offset.minus(T::ONE);
        }
    }
    lowest
}
