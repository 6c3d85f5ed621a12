//! Costs of moves on the grid, in integers.

use crate::map::Cell;

/// Cost of a move to one of the four nearest cells.
pub const STRAIGHT: u64 = 13_860;

/// Cost of a diagonal move: 19601/13860 is sqrt 2 within 2e-9, so that sums order paths as their lengths do.
pub const DIAGONAL: u64 = 19_601;

/// Cost of the way between two cells on open ground (eqs. 16 and 17).
#[inline]
pub(super) fn octile(one: Cell, other: Cell) -> u64 {
    let dx = one.column.abs_diff(other.column);
    let dy = one.row.abs_diff(other.row);
    u64::from(dx.max(dy)) * STRAIGHT + u64::from(dx.min(dy)) * (DIAGONAL - STRAIGHT)
}
