//! Entries of a grid that are near together: as many as registers hold.

/// The side of a small patch.
pub const SMALL_TILE: usize = 8;
/// The side of a large one.
pub const LARGE_TILE: usize = 16;

/// Entries of a large patch, and two more, for vectors that read two at a time.
const ROOM: usize = LARGE_TILE * LARGE_TILE + 2;

/// Where a square of a grid is.
#[derive(Clone, Copy, Debug)]
pub struct Square<'a> {
    /// The grid's entries from the first one of the square to the last one, at least, row by row.
    pub entries: &'a [u16],
    /// From one row to the next.
    pub stride: usize,
    /// The first column.
    pub column: usize,
    /// The first row.
    pub row: usize,
}

impl<'a> Square<'a> {
    /// The entries of a square of this side in the row whose number is this, modulo the side.
    #[inline(always)]
    pub fn row<const SIDE: usize>(&self, row: usize) -> &'a [u16] {
        let after = row.wrapping_sub(self.row) % SIDE;
        &self.entries[after * self.stride..][..SIDE]
    }
}

/// A patch in memory: each entry at its column and row in the grid modulo the side, row by row.
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
