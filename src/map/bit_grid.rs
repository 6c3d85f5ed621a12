//! A bit for each grid cell, packed so that a search reads 64 cells at once.

use super::Cell;

/// Bits in a word.
const WORD: usize = u64::BITS as usize;

/// A boolean for each cell, with a border of false bits on all sides.
///
/// Rows are stored one after the other, lowest row first. Each row is padded with false bits to whole words, with at
/// least one bit of padding, and one false row lies below the first and above the last. The neighbours of any cell can
/// therefore be read without a bounds check.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct BitGrid {
    width: i32,
    height: i32,
    /// Bits from a cell to the one above it.
    stride: usize,
    words: Vec<u64>,
}

impl BitGrid {
    /// Creates an all-false grid with the given size.
    pub fn new(width: i32, height: i32) -> Self {
        // At least one bit of padding after the last column.
        let stride = (width as usize / WORD + 1) * WORD;
        // One extra word at each end, for windows that start before the first row or end after the last.
        let words = vec![0; stride / WORD * (height as usize + 2) + 2];
        Self { width, height, stride, words }
    }

    /// Creates a grid from one value per cell, row-major, lowest row first.
    pub fn from_cells(width: i32, height: i32, cells: &[bool]) -> Self {
        let mut grid = Self::new(width, height);
        for (row, cells) in (0..height).zip(cells.chunks_exact(width as usize)) {
            for (word, cells) in grid.row_mut(row).iter_mut().zip(cells.chunks(WORD)) {
                let (bytes, rest) = cells.as_chunks();
                for (number, byte) in bytes.iter().enumerate() {
                    *word |= packed(byte) << (8 * number);
                }
                for (number, &cell) in (8 * bytes.len()..).zip(rest) {
                    *word |= u64::from(cell) << number;
                }
            }
        }
        grid
    }

    /// Returns the grid with rows and columns exchanged.
    pub fn transposed(&self) -> Self {
        let mut turned = Self::new(self.height, self.width);
        let mut block = [0; WORD];
        for row in (0..self.height).step_by(WORD) {
            for column in (0..self.width).step_by(WORD) {
                let number = column as usize / WORD;
                for (line, word) in (row..).zip(&mut block) {
                    *word = if line < self.height { self.row(line)[number] } else { 0 };
                }
                transpose(&mut block);
                let number = row as usize / WORD;
                for (line, &word) in (column..turned.height).zip(&block) {
                    turned.row_mut(line)[number] = word;
                }
            }
        }
        turned
    }

    /// Returns the cells that are false in both grids. The grids have the same size.
    pub fn nor(&self, other: &Self) -> Self {
        let mut grid = Self::new(self.width, self.height);
        for row in 0..self.height {
            let pairs = self.row(row).iter().zip(other.row(row));
            for (to, (one, other)) in grid.row_mut(row).iter_mut().zip(pairs) {
                *to = !(one | other);
            }
            clear_padding(grid.row_mut(row), self.width);
        }
        grid
    }

    /// Keeps the cells that are true in another grid of the same size too.
    pub fn intersect(&mut self, other: &Self) {
        self.words.iter_mut().zip(&other.words).for_each(|(to, from)| *to &= from);
    }

    /// Columns of the nearest true cells of a row: at a column or left of it, and right of it.
    pub fn nearest_in_row(&self, row: i32, column: i32) -> [Option<i32>; 2] {
        let words = self.row(row);
        let (number, bit) = (column as usize / WORD, column as usize % WORD);
        let up_to = u64::MAX >> (WORD - 1 - bit);
        let word = |number: usize| (number, words[number]);
        let is_set = |&(_, word): &(usize, u64)| word != 0;
        let left = [(number, words[number] & up_to)];
        let left = left.into_iter().chain((0..number).rev().map(word)).find(is_set);
        let right = [(number, words[number] & !up_to)];
        let right = right.into_iter().chain((number + 1..words.len()).map(word)).find(is_set);
        let column = |number: usize, bit: u32| (number * WORD) as i32 + bit as i32;
        [
            left.map(|(number, word)| column(number, word.ilog2())),
            right.map(|(number, word)| column(number, word.trailing_zeros())),
        ]
    }

    /// Distance in bits from a cell to the cell above it.
    pub const fn stride(&self) -> usize {
        self.stride
    }

    /// Bit position of a cell, which may lie one cell outside the grid.
    pub const fn position(&self, column: i32, row: i32) -> usize {
        ((row + 1) as usize * self.stride + WORD).wrapping_add_signed(column as isize)
    }

    /// The 64 bits from a position upwards; the lowest bit is the position's own.
    #[inline]
    pub fn window(&self, position: usize) -> u64 {
        let (word, shift) = (position / WORD, position % WORD);
        self.words[word] >> shift | self.words[word + 1] << 1 << (WORD - 1 - shift)
    }

    /// The bit at a position.
    #[inline]
    pub fn at(&self, position: usize) -> bool {
        self.words[position / WORD] >> (position % WORD) & 1 != 0
    }

    /// The bit of a cell; false outside the grid.
    pub fn get(&self, cell: Cell) -> bool {
        let inside = (0..self.width).contains(&cell.column) && (0..self.height).contains(&cell.row);
        inside && self.at(self.position(cell.column, cell.row))
    }

    /// Sets the bit of a cell, which must lie inside the grid.
    pub fn set(&mut self, cell: Cell, value: bool) {
        debug_assert!(
            (0..self.width).contains(&cell.column) && (0..self.height).contains(&cell.row)
        );
        let position = self.position(cell.column, cell.row);
        let bit = 1 << (position % WORD);
        let word = &mut self.words[position / WORD];
        *word = if value { *word | bit } else { *word & !bit };
    }

    /// The words of a row, including its padding.
    pub fn row(&self, row: i32) -> &[u64] {
        let first = self.position(0, row) / WORD;
        &self.words[first..first + self.stride / WORD]
    }

    /// The words of a row, mutable. The padding must stay zero.
    pub fn row_mut(&mut self, row: i32) -> &mut [u64] {
        let first = self.position(0, row) / WORD;
        &mut self.words[first..first + self.stride / WORD]
    }

    /// Whether all cells of a row between two columns, both included, are set. False if a cell lies outside the grid.
    pub fn all_set_in_row(&self, row: i32, columns: core::ops::RangeInclusive<i32>) -> bool {
        let inside = *columns.start() >= 0 && *columns.end() < self.width;
        if !(inside && (0..self.height).contains(&row)) {
            return columns.is_empty();
        }
        let mut position = self.position(*columns.start(), row);
        let mut left = (*columns.end() - *columns.start() + 1).max(0) as usize;
        while left > WORD {
            if self.window(position) != u64::MAX {
                return false;
            }
            position += WORD;
            left -= WORD;
        }
        left == 0 || !self.window(position) << (WORD - left) == 0
    }

    /// Number of set cells.
    pub fn count(&self) -> usize {
        self.words.iter().map(|word| word.count_ones() as usize).sum()
    }
}

/// Packs eight values into a byte, the first as the lowest bit.
fn packed(cells: &[bool; 8]) -> u64 {
    // The product moves byte i by 7 (8 - i) bits, onto bit i of the highest byte; no other term reaches that byte.
    u64::from_le_bytes(cells.map(u8::from)).wrapping_mul(0x0102_0408_1020_4080) >> 56
}

/// Clears the padding after the last column of a row.
pub(super) fn clear_padding(row: &mut [u64], width: i32) {
    let (whole, rest) = (width as usize / WORD, width as usize % WORD);
    row[whole] &= (1 << rest) - 1;
}

/// Transposes a square of bits: bit `i` of word `j` becomes bit `j` of word `i`. Swaps halves recursively.
fn transpose(block: &mut [u64; WORD]) {
    let (mut width, mut mask) = (WORD / 2, u64::MAX >> (WORD / 2));
    while width > 0 {
        for line in (0..WORD).filter(|line| line & width == 0) {
            let swapped = (block[line] >> width ^ block[line + width]) & mask;
            block[line] ^= swapped << width;
            block[line + width] ^= swapped;
        }
        width /= 2;
        mask ^= mask << width;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Widths and heights below, at and above multiples of a word.
    const SIDES: [(i32, i32); 7] =
        [(1, 1), (5, 70), (63, 3), (64, 64), (65, 2), (130, 67), (3, 200)];

    fn is_set(width: i32, cell: Cell) -> bool {
        (cell.row * width + cell.column) * 7919 % 11 < 6
    }

    fn grid(width: i32, height: i32) -> BitGrid {
        let cells = (0..width * height)
            .map(|index| is_set(width, Cell::new(index % width, index / width)))
            .collect::<Vec<_>>();
        BitGrid::from_cells(width, height, &cells)
    }

    #[test]
    fn bit_grid_keeps_cells_and_an_empty_border() {
        for (width, height) in SIDES {
            let grid = grid(width, height);
            let turned = grid.transposed();
            assert_eq!(turned.transposed(), grid);
            let mut count = 0;
            for row in -1..=height {
                for column in -1..=width {
                    let cell = Cell::new(column, row);
                    let inside = (0..width).contains(&column) && (0..height).contains(&row);
                    let expected = inside && is_set(width, cell);
                    assert_eq!(grid.get(cell), expected);
                    assert_eq!(grid.at(grid.position(column, row)), expected);
                    assert_eq!(turned.get(Cell::new(row, column)), expected);
                    assert_eq!(grid.window(grid.position(column, row)) & 1 != 0, expected);
                    count += usize::from(expected);
                }
            }
            assert_eq!(grid.count(), count);
            for row in 0..height {
                for column in 0..width {
                    let is_true = |other: &i32| grid.get(Cell::new(*other, row));
                    let nearest =
                        [(0..=column).rev().find(is_true), (column + 1..width).find(is_true)];
                    assert_eq!(grid.nearest_in_row(row, column), nearest, "{row}, {column}");
                }
            }
        }
    }

    #[test]
    fn all_set_in_row_checks_every_column_of_the_range() {
        let (width, height) = (200, 3);
        let mut grid = BitGrid::from_cells(width, height, &[true; 600]);
        for (row, columns) in [(-1, 0..=1), (3, 0..=1), (0, -1..=3), (0, 4..=200)] {
            assert!(!grid.all_set_in_row(row, columns));
        }
        grid.set(Cell::new(100, 1), false);
        for from in 0..width {
            for to in from - 1..width {
                assert!(grid.all_set_in_row(0, from..=to));
                let holds = to < 100 || from > 100 || to < from;
                assert_eq!(grid.all_set_in_row(1, from..=to), holds, "{from} to {to}");
            }
        }
    }
}
