//! Compact cells for the search.

use crate::map::{Cell, GridFrame};

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
