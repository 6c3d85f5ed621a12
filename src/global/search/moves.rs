//! Compact cells, the eight moves between them, and the moves allowed from a cell.

use crate::global::heuristic::{DIAGONAL, STRAIGHT};
use crate::map::{BitGrid, Cell, GridFrame};

/// A cell in four bytes: the row in the upper half, the column in the lower. Grid sides need 15 bits.
///
/// Nodes are ordered as cells are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Node(u32);

impl Node {
    /// The cell must lie inside a grid.
    pub const fn new(cell: Cell) -> Self {
        Self((cell.row as u32) << 16 | cell.column as u32)
    }

    /// The packed representation.
    pub const fn bits(self) -> u32 {
        self.0
    }

    /// Unpacks the value of [`Self::bits`].
    pub const fn from_bits(bits: u32) -> Self {
        Self(bits)
    }

    /// The cell.
    #[inline]
    pub const fn cell(self) -> Cell {
        Cell::new((self.0 & 0xffff) as i32, (self.0 >> 16) as i32)
    }

    /// Index of the cell in its grid.
    #[inline]
    pub const fn index(self, frame: &GridFrame) -> usize {
        (self.0 >> 16) as usize * frame.width as usize + (self.0 & 0xffff) as usize
    }

    /// The cell at an offset, which must lie inside the grid.
    #[inline]
    pub const fn moved(self, columns: i32, rows: i32) -> Self {
        Self(self.0.wrapping_add_signed(rows * 0x1_0000 + columns))
    }
}

/// Column and row offset of each move: four straight moves counter-clockwise, then four diagonal ones, each between the
/// straight move of the same index and the next.
pub(super) const MOVES: [(i32, i32); 8] =
    [(1, 0), (0, 1), (-1, 0), (0, -1), (1, 1), (-1, 1), (-1, -1), (1, -1)];

/// Cost of each move.
pub(super) const COSTS: [u64; 8] =
    [STRAIGHT, STRAIGHT, STRAIGHT, STRAIGHT, DIAGONAL, DIAGONAL, DIAGONAL, DIAGONAL];

/// The allowed moves, one bit each, by the free cells among a cell and its eight neighbours: three bits each for the row
/// below, the own row and the row above, from the left.
const ALLOWED: [u8; 512] = {
    let mut allowed = [0; 512];
    let mut free = 0;
    while free < 512 {
        let mut number = 0;
        while number < 8 {
            let (dx, dy) = MOVES[number];
            // A diagonal needs both adjacent cells; a straight move checks its own cell twice.
            let all = is_free(free, dx, dy) && is_free(free, dx, 0) && is_free(free, 0, dy);
            allowed[free] |= (all as u8) << number;
            number += 1;
        }
        free += 1;
    }
    allowed
};

const fn is_free(free: usize, dx: i32, dy: i32) -> bool {
    let own = dx == 0 && dy == 0;
    own || free >> (3 * (dy + 1) + dx + 1) & 1 != 0
}

/// The moves allowed from the cell at a position, one bit each.
#[inline]
pub(super) fn allowed(free: &BitGrid, position: usize) -> u8 {
    let left = position - 1;
    let row = |from: usize| free.window(from) as usize & 7;
    let [below, own, above] = [left - free.stride(), left, left + free.stride()].map(row);
    ALLOWED[below | own << 3 | above << 6]
}
