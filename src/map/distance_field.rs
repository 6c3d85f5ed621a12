//! Exact integer distance from every cell to the nearest obstacle.
//!
//! A row of the field is the lowest of the parabolas `(x - site)^2 + height(site)^2` at each column.
//!
//! The lowest site never moves left as the column increases, so the lowest sites of two columns bound those of all
//! columns between them. The lowest site of every sixteenth column is found by bisection. All sites between two of these
//! are then compared at the sixteen columns between, sixteen at once: about twenty comparisons per column, vectorised
//! and without data-dependent branches. A stack-based envelope mispredicts at every other column of rough terrain.

use core::f64::consts::SQRT_2;

use multiversion::multiversion;

use super::{Cell, GridFrame, ObstacleGrid};

/// The squared distance, in cells, from each cell's centre to the centre of the nearest obstacle cell.
///
/// Exact Euclidean distance transform in two passes (Meijster, Roerdink and Hesselink, 2000): first along the columns,
/// then along each row as the lower envelope of one parabola per column. All numbers are integers.
#[derive(Clone, Debug, PartialEq)]
pub struct DistanceField {
    frame: GridFrame,
    squared: Vec<u32>,
}

/// Marks a column without an obstacle: longer than any distance within a grid, and its square fits in an `i32`.
const FAR: u16 = 46_000;

impl DistanceField {
    /// The squared distance stored if the grid has no obstacle.
    pub const NO_OBSTACLE: u32 = FAR as u32 * FAR as u32;

    /// Computes the field of an obstacle grid. The area outside the grid is not an obstacle here.
    #[must_use]
    pub fn new(obstacles: &ObstacleGrid) -> Self {
        let frame = *obstacles.frame();
        let width = frame.width as usize;
        let mut squared = vec![0; frame.len()];
        Self::for_each_row(obstacles, |row, squared_cells| {
            squared[row * width..][..width].copy_from_slice(squared_cells);
        });
        Self { frame, squared }
    }

    /// Computes the squared distances of [`Self::new`] and passes each row with its index to `take`, in unspecified
    /// order. Callers that store another format avoid an intermediate copy.
    pub(crate) fn for_each_row(obstacles: &ObstacleGrid, mut take: impl FnMut(usize, &[u32])) {
        let width = obstacles.frame().width as usize;
        let mut squared = vec![Self::NO_OBSTACLE; width];
        if !obstacles.cells().contains(&true) {
            (0..obstacles.frame().height as usize).for_each(|row| take(row, &squared));
            return;
        }
        let mut reach = Reach::unknown(width);
        let (mut near, mut any) = (Row::<u16>::new(width), Row::<f64>::new(width));
        let mut heights = vec![FAR; width];
        let downwards = distance_downwards(obstacles);
        // From the highest row down, so that the distances upwards follow from the row above.
        for (row, downwards) in downwards.chunks_exact(width).enumerate().rev() {
            for (height, &below) in heights.iter_mut().zip(downwards) {
                *height = height.saturating_add(1).min(below);
            }
            if reach.is_near(width) {
                lower(&mut near, &heights, &mut reach, &mut squared);
            } else {
                lower(&mut any, &heights, &mut reach, &mut squared);
            }
            take(row, &squared);
        }
    }

    /// Size and pose of the grid.
    #[must_use]
    pub const fn frame(&self) -> &GridFrame {
        &self.frame
    }

    /// All squared distances in cells, row-major, lowest row first.
    #[must_use]
    pub fn squared_cells(&self) -> &[u32] {
        &self.squared
    }

    /// A lower bound, in cells, of the distance from any point of a cell to the nearest obstacle's square, by the squared distance
    /// between their centres. A point and a square each extend half a diagonal from theirs. Infinite without obstacles.
    pub(crate) fn free_cells(squared: u32) -> f64 {
        if squared >= Self::NO_OBSTACLE {
            return f64::INFINITY;
        }
        f64::from(squared).sqrt() - SQRT_2
    }

    /// Distance in metres from the centre of a cell to the centre of the nearest obstacle cell; infinite if the grid has
    /// no obstacle. The cell must lie inside the grid.
    #[must_use]
    pub fn distance_m(&self, cell: Cell) -> f64 {
        match self.squared[self.frame.index(cell)] {
            Self::NO_OBSTACLE.. => f64::INFINITY,
            squared => f64::from(squared).sqrt() * self.frame.resolution_m,
        }
    }
}

/// For each cell, the distance in rows to the nearest obstacle of the same column at or below it, or [`FAR`].
fn distance_downwards(obstacles: &ObstacleGrid) -> Vec<u16> {
    let width = obstacles.frame().width as usize;
    let mut distances = vec![0; obstacles.cells().len()];
    let mut heights = vec![FAR; width];
    let rows = obstacles.cells().chunks_exact(width);
    for (blocked, out) in rows.zip(distances.chunks_exact_mut(width)) {
        for ((height, &blocked), out) in heights.iter_mut().zip(blocked).zip(out) {
            let above = height.saturating_add(1).min(FAR);
            *height = if blocked { 0 } else { above };
            *out = *height;
        }
    }
    distances
}

/// Columns compared at once.
const BLOCK: usize = 16;
/// Sites compared at once.
const SITES: usize = 8;
/// Sites between two checks of the end.
const UNROLLED: usize = 4;
/// Above this width, the column indices including the padding do not fit in `u16`.
const WIDEST: usize = 65_000;

/// Upper bounds of the distance to the nearest obstacle, in cells, in the most recently computed row: for the first column
/// of each block and for the last column. The bound for the next row is at most one larger.
struct Reach(Vec<usize>);

impl Reach {
    /// The bounds before the first row.
    fn unknown(width: usize) -> Self {
        Self(vec![usize::from(FAR); width.div_ceil(BLOCK) + 1])
    }

    /// Whether `u16` is sufficient for the next row. Distances at the known columns are then at most 214 cells, so those
    /// between are at most 222, and sites are at most 230 columns from the columns where they are compared. Both are
    /// below 255, at which `u16` saturates.
    fn is_near(&self, width: usize) -> bool {
        width <= WIDEST && self.0.iter().all(|&reach| reach < 214)
    }
}

/// Working memory for one row, padded to a whole last block and a whole last group of sites.
struct Row<T> {
    columns: Vec<T>,
    squared_heights: Vec<T>,
    /// The lowest site at the columns of [`Reach`].
    nearest: Vec<usize>,
    lowest: Vec<[T; BLOCK]>,
}

impl<T: Lane> Row<T> {
    fn new(width: usize) -> Self {
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
fn lower<T: Lane>(row: &mut Row<T>, heights: &[u16], reach: &mut Reach, squared: &mut [u32]) {
    row.lower(heights, reach, squared);
}

/// The lowest values at these columns of the parabolas of adjacent sites, up to and including `last`, and of up to three more.
///
/// The loop checks the end on purpose. With a known trip count the compiler vectorises over sites instead of columns, which takes
/// three times as long.
#[inline(always)]
fn lowest_of<T: Lane>(
    columns: &[T; BLOCK],
    sites: &[T],
    squared_heights: &[T],
    last: T,
) -> [T; BLOCK] {
    let mut lowest = [T::MOST; BLOCK];
    let mut offsets = columns.map(|column| column.minus(sites[0]));
    let (sites, _) = sites.as_chunks::<UNROLLED>();
    let (squared_heights, _) = squared_heights.as_chunks::<UNROLLED>();
    for (sites, squared_heights) in sites.iter().zip(squared_heights) {
        if sites[0] > last {
            break;
        }
        for &squared_height in squared_heights {
            for (lowest, offset) in lowest.iter_mut().zip(&mut offsets) {
                let value = T::parabola(*offset, squared_height);
                *lowest = if value < *lowest { value } else { *lowest };
                // The next site is one column to the right.
                *offset = offset.minus(T::ONE);
            }
        }
    }
    lowest
}

/// A number type for vector code: several values fit in a register. Operations are unchecked, since overflow checks
/// prevent vectorisation; the caller keeps relevant values in range.
trait Lane: Copy + PartialOrd {
    const ONE: Self;
    /// At least as large as any relevant value.
    const MOST: Self;

    /// Converts a column index.
    fn column(column: usize) -> Self;
    /// Squares the vertical distance of a column to its obstacle, in cells.
    fn square_of_height(height: u16) -> Self;
    fn minus(self, other: Self) -> Self;
    /// Returns `offset^2 + squared_height`: the value of a parabola at this offset from its site.
    fn parabola(offset: Self, squared_height: Self) -> Self;
    /// Converts a non-negative whole number.
    fn whole(self) -> u32;
}

/// Heights from this value on are treated as equal by [`u16`]: its square is the largest that fits.
const HIGHEST_NEAR: u16 = 255;

/// At least eight lanes. Exact below `255^2`; larger values are saturated to at least that.
impl Lane for u16 {
    const ONE: Self = 1;
    const MOST: Self = Self::MAX;

    #[inline(always)]
    fn column(column: usize) -> Self {
        column as Self
    }

    #[inline(always)]
    fn square_of_height(height: u16) -> Self {
        let height = height.min(HIGHEST_NEAR);
        height.wrapping_mul(height)
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        self.wrapping_sub(other)
    }

    /// A negative offset wraps, and its square is still correct.
    #[inline(always)]
    fn parabola(offset: Self, squared_height: Self) -> Self {
        offset.wrapping_mul(offset).saturating_add(squared_height)
    }

    #[inline(always)]
    fn whole(self) -> u32 {
        self.into()
    }
}

/// Two lanes, exact for every grid: no sum reaches `2^53`.
impl Lane for f64 {
    const ONE: Self = 1.0;
    const MOST: Self = 4.0 * FAR as Self * FAR as Self;

    #[inline(always)]
    fn column(column: usize) -> Self {
        column as Self
    }

    #[inline(always)]
    fn square_of_height(height: u16) -> Self {
        Self::from(height) * Self::from(height)
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        self - other
    }

    #[inline(always)]
    fn parabola(offset: Self, squared_height: Self) -> Self {
        offset * offset + squared_height
    }

    /// Adding `2^52` leaves the whole number in the low bits. This vectorises; a cast does not.
    #[inline(always)]
    fn whole(self) -> u32 {
        const TWO_TO_52: f64 = 4_503_599_627_370_496.0;
        (self + TWO_TO_52).to_bits() as u32
    }
}
