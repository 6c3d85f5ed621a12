//! Bounds of the scores of many poses at once, for branch and bound.
//!
//! The method is that of Hess, Kohler, Rapp and Andor, "Real-Time Loop Closure in 2D LIDAR SLAM", ICRA 2016. Coarser levels hold the
//! maximum of the scores of 2^k x 2^k cells. The sum over the cells of a scan therefore bounds the sums of all translations of a
//! block.
//!
//! A block of 2^k x 2^k translations begins at multiples of 2^k. From block to block the end of a beam therefore moves over every
//! 2^k-th column and row, and level k holds these cells together: 2^k x 2^k tiles, one for each remainder of column and row. The
//! ends of a beam for the four quarters of a block are then next to each other, and one pass over the beams bounds all four.

use multiversion::multiversion;

/// Beam ends that are added at once. The sum of this number of scores fits in 16 bits.
const LANES: usize = 64;

/// A tile has zeros around it, so that a quarter outside of it needs no check: those on the right and above are also those on the left of
/// the next row and below the next tile.
const MARGIN: i32 = 3;

/// More cells than any grid has along a side.
const FAR: i32 = 1 << 29;

/// The cells of beam ends relative to the robot, columns and rows, at one heading.
#[derive(Clone, Debug)]
pub(crate) struct EndCells(Vec<Lanes>);

/// The last lanes may be unused.
#[derive(Clone, Debug)]
struct Lanes {
    used: usize,
    columns: [i32; LANES],
    rows: [i32; LANES],
}

impl EndCells {
    pub fn new(cells: &[(i32, i32)]) -> Self {
        let lanes = cells.chunks(LANES).map(|cells| {
            let mut lanes = Lanes { used: cells.len(), columns: [0; LANES], rows: [0; LANES] };
            for (lane, (column, row)) in cells.iter().enumerate() {
                lanes.columns[lane] = (*column).clamp(-FAR, FAR);
                lanes.rows[lane] = (*row).clamp(-FAR, FAR);
            }
            lanes
        });
        Self(lanes.collect())
    }
}

/// Scores of cells, and their maxima.
#[derive(Clone, Debug)]
pub(crate) struct ScorePyramid {
    columns: i32,
    rows: i32,
    /// Level k holds at each cell the maximum over 2^k columns to the right and 2^k rows up.
    levels: Vec<Level>,
}

impl ScorePyramid {
    /// The pyramid of scores in rows, the lowest first.
    pub fn new(columns: i32, rows: i32, scores: &[u8], levels: usize) -> Self {
        let mut pyramid = Self { columns, rows, levels: vec![Level::finest(columns, scores)] };
        for level in 1..levels {
            pyramid.levels.push(Level::coarser(&pyramid.levels[level - 1], columns, rows));
        }
        pyramid
    }

    pub const fn columns(&self) -> i32 {
        self.columns
    }

    pub const fn rows(&self) -> i32 {
        self.rows
    }

    /// Level of the largest blocks.
    pub const fn top(&self) -> usize {
        self.levels.len() - 1
    }

    /// The score of a cell; 0 outside.
    #[cfg(any(test, feature = "logs"))]
    pub fn score(&self, column: i32, row: i32) -> u8 {
        let is_inside = (0..self.columns).contains(&column) && (0..self.rows).contains(&row);
        let finest = &self.levels[0];
        if is_inside { finest.scores[finest.index((0, 0), column, row)] } else { 0 }
    }

    /// Changes the highest bit of a cell's score.
    #[cfg(test)]
    pub fn flip_bit(&mut self, column: i32, row: i32) {
        let at = self.levels[0].index((0, 0), column, row);
        self.levels[0].scores[at] ^= 1 << 7;
    }

    /// Bounds of the sums of the cells over all translations of four blocks of a level: of the one that begins at `right` and `up`,
    /// of the one above it, and of those on their right. A translation of a block is by up to 2^level - 1 more cells of both. At
    /// level 0 a bound is the sum itself.
    ///
    /// `right` and `up` are multiples of 2^level, and not below zero.
    pub fn sums_of_four(&self, level: usize, ends: &EndCells, right: i32, up: i32) -> [u32; 4] {
        let level = &self.levels[level];
        let (right, up) = (right >> level.log_side, up >> level.log_side);
        let mut sums = [0; 4];
        for lanes in &ends.0 {
            for (sum, more) in sums.iter_mut().zip(add(level, lanes, right, up)) {
                *sum += u32::from(more);
            }
        }
        sums
    }
}

/// The scores of a level by tiles.
#[derive(Clone, Debug)]
struct Level {
    /// The side of a block is two to this power of cells.
    log_side: u32,
    /// Number of blocks from left to right, and from below.
    columns: i32,
    rows: i32,
    scores: Vec<u8>,
}

impl Level {
    fn finest(columns: i32, scores: &[u8]) -> Self {
        let mut level = Self::zeros(columns, (scores.len() / columns as usize) as i32, 0);
        for (row, scores) in scores.chunks_exact(columns as usize).enumerate() {
            let at = level.index((0, 0), 0, row as i32);
            level.scores[at..][..scores.len()].copy_from_slice(scores);
        }
        level
    }

    /// The level above another one, of a grid with these numbers of columns and rows.
    fn coarser(below: &Self, columns: i32, rows: i32) -> Self {
        let mut level = Self::zeros(columns, rows, below.log_side + 1);
        let half = below.side();
        let width = level.columns as usize + 1;
        for tile in level.tiles() {
            let (right, up) = (tile.0 / half, tile.1 / half);
            let tile_below = (tile.0 % half, tile.1 % half);
            for row in -1..level.rows {
                let pairs_from = |row: i32| {
                    let at = below.index(tile_below, right - 2, row);
                    below.scores[at..][..2 * width].as_chunks::<2>().0
                };
                let (low, high) = (pairs_from(2 * row + up), pairs_from(2 * row + up + 1));
                let at = level.index(tile, -1, row);
                let out = level.scores[at..][..width].iter_mut();
                for ((out, low), high) in out.zip(low).zip(high) {
                    *out = low[0].max(low[1]).max(high[0].max(high[1]));
                }
            }
        }
        level.set_borders();
        level
    }

    fn zeros(columns: i32, rows: i32, log_side: u32) -> Self {
        let blocks = |cells: i32| (cells as u32).div_ceil(1 << log_side) as i32;
        let (columns, rows) = (blocks(columns), blocks(rows));
        let mut level = Self { log_side, columns, rows, scores: Vec::new() };
        let tiles = 1 << (2 * log_side);
        level.scores = vec![0; tiles * level.area() as usize + 2 * level.stride() as usize + 2];
        level
    }

    /// A cell on the left of the grid or below still covers cells of the grid. It has the score of the first one.
    fn set_borders(&mut self) {
        let side = self.side();
        for row in 0..side {
            for up in 0..self.rows {
                let first = self.scores[self.index((0, row), 0, up)];
                for column in 1..side {
                    let at = self.index((column, row), -1, up);
                    self.scores[at] = first;
                }
            }
        }
        for column in 0..side {
            for right in -1..self.columns {
                let first = self.scores[self.index((column, 0), right, 0)];
                for row in 1..side {
                    let at = self.index((column, row), right, -1);
                    self.scores[at] = first;
                }
            }
        }
    }

    const fn side(&self) -> i32 {
        1 << self.log_side
    }

    /// The remainders of column and row of each tile.
    fn tiles(&self) -> impl Iterator<Item = (i32, i32)> + use<> {
        let side = self.side();
        (0..side).flat_map(move |row| (0..side).map(move |column| (column, row)))
    }

    /// Number of scores from a row of a tile to the next one, and from tile to tile.
    const fn stride(&self) -> u32 {
        (self.columns + MARGIN) as u32
    }

    const fn area(&self) -> u32 {
        self.stride() * (self.rows + MARGIN) as u32
    }

    /// Where the score of a block in a tile lies.
    const fn index(&self, (column, row): (i32, i32), right: i32, up: i32) -> usize {
        let tile = row << self.log_side | column;
        let within = (up + MARGIN) as usize * self.stride() as usize + (right + MARGIN) as usize;
        tile as usize * self.area() as usize + within
    }
}

/// Adds the scores of four neighbouring blocks, with the widest vectors of the processor.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn add(level: &Level, lanes: &Lanes, right: i32, up: i32) -> [u16; 4] {
    add_in_lanes(level, lanes, right, up)
}

/// The sums wrap nowhere, and vectors have no checked ones.
#[inline(always)]
fn add_in_lanes(level: &Level, lanes: &Lanes, right: i32, up: i32) -> [u16; 4] {
    let (log_side, within_block) = (level.log_side, level.side() - 1);
    let (area, stride) = (level.area(), level.stride());
    let mut indices = [0_u32; LANES];
    for ((index, &column), &row) in indices.iter_mut().zip(&lanes.columns).zip(&lanes.rows) {
        let tile = (row & within_block).wrapping_shl(log_side) | (column & within_block);
        let column = column.wrapping_shr(log_side).wrapping_add(right);
        let row = row.wrapping_shr(log_side).wrapping_add(up);
        let column = column.max(-MARGIN).min(level.columns).wrapping_add(MARGIN) as u32;
        let row = row.max(-MARGIN).min(level.rows).wrapping_add(MARGIN) as u32;
        let within = row.wrapping_mul(stride).wrapping_add(column);
        *index = (tile as u32).wrapping_mul(area).wrapping_add(within);
    }
    let stride = stride as usize;
    let (mut low, mut high) = ([0_u16; LANES], [0_u16; LANES]);
    for ((&index, low), high) in indices[..lanes.used].iter().zip(&mut low).zip(&mut high) {
        let scores = &level.scores[index as usize..][..stride + 2];
        *low = u16::from_le_bytes([scores[0], scores[1]]);
        *high = u16::from_le_bytes([scores[stride], scores[stride + 1]]);
    }
    let mut sums = [0_u16; 4];
    for (low, high) in low.into_iter().zip(high) {
        let four = [low & 0xFF, high & 0xFF, low >> 8, high >> 8];
        for (sum, score) in sums.iter_mut().zip(four) {
            *sum = sum.wrapping_add(score);
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    use super::*;

    struct Case {
        columns: i32,
        rows: i32,
        scores: Vec<u8>,
        pyramid: ScorePyramid,
    }

    impl Case {
        fn new(random: &mut Pcg64Mcg, (columns, rows): (i32, i32)) -> Self {
            let scores: Vec<u8> = (0..columns * rows).map(|_| random.random()).collect();
            let pyramid = ScorePyramid::new(columns, rows, &scores, 5);
            Self { columns, rows, scores, pyramid }
        }

        /// The highest score in a block of cells. One that begins on the left of the grid or below begins at the border instead.
        fn bound(&self, level: usize, column: i64, row: i64) -> u32 {
            let (side, columns, rows) = (1 << level, i64::from(self.columns), i64::from(self.rows));
            if column <= -side || row <= -side {
                return 0;
            }
            let rows = row.max(0)..(row.max(0) + side).min(rows);
            let columns = column.max(0)..(column.max(0) + side).min(columns);
            let score =
                |column, row| self.scores[(row * i64::from(self.columns) + column) as usize];
            let all = rows.flat_map(|row| columns.clone().map(move |column| score(column, row)));
            u32::from(all.max().unwrap_or(0))
        }

        /// Compares the bounds of all nodes for such ends of beams with the scores.
        fn compare(&self, cells: &[(i32, i32)]) -> Result<(), String> {
            let ends = EndCells::new(cells);
            for level in 0..=self.pyramid.top() {
                let side = 1 << level;
                let places = |cells: i32| (0..cells + side).step_by(side as usize);
                for up in places(self.rows) {
                    for right in places(self.columns) {
                        let sums = self.pyramid.sums_of_four(level, &ends, right, up);
                        let quarters = [(0, 0), (0, side), (side, 0), (side, side)];
                        let expected = quarters.map(|(x, y)| {
                            let bound = |(column, row): &(i32, i32)| {
                                let at = |cell: i32, by: i32| i64::from(cell) + i64::from(by);
                                self.bound(level, at(*column, right + x), at(*row, up + y))
                            };
                            cells.iter().map(bound).sum::<u32>()
                        });
                        let found = &self.pyramid.levels[level];
                        let mut portable = [0; 4];
                        for lanes in &ends.0 {
                            let more = add_in_lanes(found, lanes, right >> level, up >> level);
                            for (sum, more) in portable.iter_mut().zip(more) {
                                *sum += u32::from(more);
                            }
                        }
                        if sums != expected || portable != expected {
                            return Err(format!(
                                "level {level} at {right}, {up}: {sums:?}, {portable:?} for {expected:?}"
                            ));
                        }
                    }
                }
            }
            Ok(())
        }

        /// Cells on the grid and around it.
        fn cells(&self, random: &mut Pcg64Mcg, count: usize) -> Vec<(i32, i32)> {
            let mut around = |cells: i32| random.random_range(-cells - 20..cells + 20);
            (0..count).map(|_| (around(self.columns), around(self.rows))).collect()
        }
    }

    const SIZES: [(i32, i32); 6] = [(13, 9), (1, 1), (1, 40), (70, 1), (33, 65), (64, 32)];

    #[test]
    fn sums_are_those_of_the_highest_scores() {
        let mut random = Pcg64Mcg::seed_from_u64(8);
        for size in SIZES {
            let case = Case::new(&mut random, size);
            for count in [0, 1, 1, 1, 1, 63, 64, 65, 200] {
                let mut cells = case.cells(&mut random, count);
                assert_eq!(case.compare(&cells), Ok(()), "{size:?}, {count} cells");
                cells.extend([(i32::MAX, 0), (0, i32::MIN), (i32::MIN, i32::MAX)]);
                assert_eq!(case.compare(&cells), Ok(()), "{size:?}, also far cells");
            }
        }
    }

    #[test]
    fn one_wrong_bit_of_any_level_is_found() {
        let mut random = Pcg64Mcg::seed_from_u64(9);
        for size in SIZES {
            let mut case = Case::new(&mut random, size);
            // From the place of a beam end over itself every block is seen.
            let all: Vec<_> =
                (0..16).flat_map(|up| (0..16).map(move |right| (right, up))).collect();
            assert_eq!(case.compare(&all), Ok(()));
            for level in 0..=case.pyramid.top() {
                let (column, row) =
                    (random.random_range(0..size.0), random.random_range(0..size.1));
                let found = &mut case.pyramid.levels[level];
                let within = found.side() - 1;
                let tile = (column & within, row & within);
                let at = found.index(tile, column >> level, row >> level);
                let bit = 1 << random.random_range(0..8);
                found.scores[at] ^= bit;
                assert_ne!(case.compare(&all), Ok(()), "{size:?}, level {level}");
                case.pyramid.levels[level].scores[at] ^= bit;
            }
        }
    }

    #[test]
    fn score_is_that_of_a_cell_and_zero_outside() {
        let case = Case::new(&mut Pcg64Mcg::seed_from_u64(10), (13, 9));
        for row in -2..11 {
            for column in -2..15 {
                let bound = case.bound(0, i64::from(column), i64::from(row));
                assert_eq!(u32::from(case.pyramid.score(column, row)), bound, "{column}, {row}");
            }
        }
    }
}
