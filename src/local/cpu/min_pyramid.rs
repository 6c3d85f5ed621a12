//! Minimum pyramid of the field: a lower bound of the entries of any rectangle of cells takes two lookups.

use super::lanes::{LaneTask, Lanes, Square};
use super::reachable_region::Region;
use crate::local::QuantizedProblem;

/// The sides of the squares are 1, 2, 4 and so on, up to 2 to this power.
const MAX_LEVEL: u32 = 4;

/// Side of the largest squares.
const LARGEST: usize = 1 << MAX_LEVEL;

/// Largest number of entries of one level: more would not stay in the cache.
const MAX_ENTRIES: usize = 1 << 18;

/// Number of lookups per cell from which building the pyramid is faster than not.
const PER_CELL: usize = 8;

/// Number of levels.
const LEVELS: usize = MAX_LEVEL as usize + 1;

/// Rows are padded to a multiple of this many entries.
const FILLED: usize = 32;

/// For each cell of a region and each level, the smallest entry of the square that begins in the cell and extends to
/// higher columns and rows. Cells beyond the region do not count.
#[derive(Debug, Default)]
pub struct MinPyramid {
    pub region: Region,
    stride: usize,
    /// Entries of one level.
    level: usize,
    pub entries: Vec<u16>,
}

/// First and last columns and rows of rectangles of cells, one rectangle per lane.
#[derive(Clone, Copy)]
pub struct Boxes<L> {
    /// First column, last column.
    pub columns: (L, L),
    /// First row, last row.
    pub rows: (L, L),
}

impl<L: Lanes> Boxes<L> {
    /// Empty boxes.
    #[inline(always)]
    pub fn empty(token: L::FeatureToken) -> Self {
        let empty = (L::splat(token, i32::MAX), L::splat(token, i32::MIN));
        Self { columns: empty, rows: empty }
    }

    /// The smallest boxes that contain both.
    #[inline(always)]
    pub fn union(self, other: Self) -> Self {
        Self { columns: union(self.columns, other.columns), rows: union(self.rows, other.rows) }
    }
}

#[inline(always)]
fn union<L: Lanes>(one: (L, L), other: (L, L)) -> (L, L) {
    (one.0.min(other.0), one.1.max(other.1))
}

impl MinPyramid {
    /// Builds the pyramid of a region, which must not be too large.
    #[inline(always)]
    pub fn fill(&mut self, problem: &QuantizedProblem, region: Region) {
        self.region = region;
        self.stride = stride(region);
        self.level = entries(region);
        // Reserves for the largest region: regions differ from one decision to the next.
        if self.entries.capacity() == 0 {
            self.entries.reserve_exact(MAX_ENTRIES * LEVELS);
        }
        self.entries.resize(self.level * LEVELS, u16::MAX);
        let cells = self.stride * region.height as usize;
        let field = problem.field.padded_units();
        let width = problem.header.width as usize;
        let corner = region.row as usize * width + region.column as usize;
        let (rows, padding) = self.entries[..self.level].split_at_mut(cells);
        for (number, row) in rows.chunks_exact_mut(self.stride).enumerate() {
            let (here, beyond) = row.split_at_mut(region.width as usize);
            here.copy_from_slice(&field[corner + number * width..][..here.len()]);
            beyond.fill(u16::MAX);
        }
        padding.fill(u16::MAX);
        for level in 0..LEVELS - 1 {
            let (smaller, larger) = self.entries.split_at_mut((level + 1) * self.level);
            let smaller = &smaller[level * self.level..];
            let (larger, padding) = larger[..self.level].split_at_mut(cells);
            build_level(smaller, larger, self.stride, 1 << level);
            padding.fill(u16::MAX);
        }
    }

    /// The square of the region that begins in this cell of the field, or in the nearest cell of the region.
    #[inline(always)]
    pub fn square(&self, column: i32, row: i32) -> Square<'_> {
        let Region { width, height, .. } = self.region;
        let across = (column - self.region.column).min(width - 1).max(0);
        let along = (row - self.region.row).min(height - 1).max(0);
        Square {
            entries: &self.entries[along as usize * self.stride + across as usize..],
            stride: self.stride,
            column: (self.region.column + across) as usize,
            row: (self.region.row + along) as usize,
        }
    }

    /// Discards the last decision's pyramid.
    pub fn clear(&mut self) {
        self.region = Region::default();
    }

    /// Whether there is no pyramid for this decision.
    pub const fn is_empty(&self) -> bool {
        self.region.cells() == 0
    }

    /// Lower bounds of the entries in the boxes; zero for a box that is too large. Boxes are clipped to the region.
    #[inline(always)]
    pub fn lower_bounds<L: Lanes>(&self, token: L::FeatureToken, boxes: &Boxes<L>) -> L {
        let Region { column, row, width, height } = self.region;
        let columns = within(token, boxes.columns, column, width);
        let rows = within(token, boxes.rows, row, height);
        let one = L::splat(token, 1);
        let wide = columns.1.sub(columns.0).add(one);
        let high = rows.1.sub(rows.0).add(one);
        // Two squares cover the box. Their side is the box's shorter side, or half of its longer side if that is more.
        let side = wide.min(high).max(wide.max(high).add(one).shr(1));
        let level = L::splat(token, 31).sub(side.add(side).sub(one).leading_zeros());
        let too_large = L::splat(token, MAX_LEVEL as i32).less(level);
        let level = level.min(L::splat(token, MAX_LEVEL as i32));
        let side = one.shl_each(level);
        let (left, right) = square_starts(token, columns, wide, side);
        let (low, high) = square_starts(token, rows, high, side);
        let stride = L::splat(token, self.stride as i32);
        let from = level.mul(L::splat(token, self.level as i32));
        let one = from.add(low.mul(stride)).add(left);
        let other = from.add(high.mul(stride)).add(right);
        let least = one
            .gather_dirty_high(&self.entries)
            .min_dirty_high(other.gather_dirty_high(&self.entries))
            .mask_high();
        L::select(too_large, L::splat(token, 0), least)
    }
}

/// Padded columns of a region.
const fn stride(region: Region) -> usize {
    (region.width as usize).next_multiple_of(FILLED)
}

/// Entries of one level. There are rows after the last one, for squares that extend beyond it and for gathers, which
/// read one more entry.
const fn entries(region: Region) -> usize {
    stride(region) * (region.height as usize + LARGEST)
}

/// Converts to indices from the region's corner and clips them.
#[inline(always)]
fn within<L: Lanes>(
    token: L::FeatureToken,
    (first, last): (L, L),
    corner: i32,
    cells: i32,
) -> (L, L) {
    let (corner, most) = (L::splat(token, corner), L::splat(token, cells - 1));
    let zero = L::splat(token, 0);
    (first.sub(corner).max(zero).min(most), last.sub(corner).max(zero).min(most))
}

/// Starts of the two squares along one axis. If the box is longer than a square, they are at both ends; otherwise both
/// are the same and contain the box in their middle.
#[inline(always)]
fn square_starts<L: Lanes>(
    token: L::FeatureToken,
    (first, last): (L, L),
    length: L,
    side: L,
) -> (L, L) {
    let zero = L::splat(token, 0);
    let over = side.sub(length).max(zero).shr(1);
    let one = first.sub(over).max(zero);
    let other = last.sub(side).add(L::splat(token, 1)).max(one);
    (one, other)
}

/// Builds squares twice as large from four smaller ones. Those that extend beyond the end of a row continue in the next
/// row: their entry may be too small, never too large.
#[inline(always)]
fn build_level(smaller: &[u16], larger: &mut [u16], stride: usize, side: usize) {
    let len = larger.len();
    let (left, right) = (&smaller[..len], &smaller[side..][..len]);
    let (above, diagonal) =
        (&smaller[side * stride..][..len], &smaller[side * stride + side..][..len]);
    for index in 0..len {
        let lower = left[index].min(right[index]);
        larger[index] = lower.min(above[index].min(diagonal[index]));
    }
}

/// Builds the pyramid of the reachable region, unless it is too large or has too few lookups per cell.
pub struct BuildMinPyramid<'a> {
    /// The pyramid to fill.
    pub pyramid: &'a mut MinPyramid,
    /// The problem with the field.
    pub problem: &'a QuantizedProblem,
}

impl LaneTask for BuildMinPyramid<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, token: L::FeatureToken) {
        let Self { pyramid, problem } = self;
        let region = Region::new::<L>(token, problem);
        let lookups = problem.len() * problem.header.steps as usize;
        let is_small = entries(region) <= MAX_ENTRIES;
        if is_small && (1..=lookups / PER_CELL).contains(&region.cells()) {
            pyramid.fill(problem, region);
        }
    }
}
