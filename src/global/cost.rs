//! Costs of moves on the grid, in integers.

/// Cost of a move to one of the four nearest cells.
pub const STRAIGHT: u64 = 13_860;

/// Cost of a diagonal move: 19601/13860 is sqrt 2 within 2e-9, so that sums order paths as their lengths do.
pub const DIAGONAL: u64 = 19_601;
