//! The eight moves on the grid, and the moves allowed from a cell.

use crate::global::heuristic::{DIAGONAL, STRAIGHT};
use crate::map::BitGrid;

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
