//! Copies of small squares of a grid, as large as registers hold.

/// Side of a small register tile.
pub const SMALL_TILE: usize = 8;
/// Side of a large register tile.
pub const LARGE_TILE: usize = 16;

/// Entries of a large register tile, and two more for vector loads.
const ROOM: usize = LARGE_TILE * LARGE_TILE + 2;

/// The position of a square in a grid.
#[derive(Clone, Copy, Debug)]
pub struct Square<'a> {
    /// Entries of the grid, row-major, at least from the first to the last entry of the square.
    pub entries: &'a [u16],
    /// Distance between rows, entries.
    pub stride: usize,
    /// The first column.
    pub column: usize,
    /// The first row.
    pub row: usize,
}

impl<'a> Square<'a> {
    /// The entries of the row whose number modulo the side is `row` modulo the side.
    #[inline(always)]
    pub fn row<const SIDE: usize>(&self, row: usize) -> &'a [u16] {
        let after = row.wrapping_sub(self.row) % SIDE;
        &self.entries[after * self.stride..][..SIDE]
    }
}

/// A register tile in memory, row-major: each entry at its column and row in the grid, modulo the side.
#[derive(Clone, Copy, Debug)]
pub struct RegisterTile([u16; ROOM]);

impl RegisterTile {
    /// Copies a square.
    #[inline(always)]
    pub fn of<const SIDE: usize>(square: &Square<'_>) -> Self {
        let mut register_tile = [0; ROOM];
        for (row, places) in register_tile.chunks_exact_mut(SIDE).take(SIDE).enumerate() {
            let entries = square.row::<SIDE>(row);
            for (column, place) in places.iter_mut().enumerate() {
                *place = entries[column.wrapping_sub(square.column) % SIDE];
            }
        }
        Self(register_tile)
    }

    /// The entries, and two more.
    #[inline(always)]
    pub const fn entries(&self) -> &[u16; ROOM] {
        &self.0
    }
}
