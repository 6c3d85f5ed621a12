//! Reference line of sight in integers: the closed cells touched by a segment between lattice points, without rounding.

use inbye::map::{Cell, FreeSpace};

/// Lattice steps per cell.
pub const STEPS: i64 = 64;

/// A point of the lattice, in steps from the grid's corner.
pub type LatticePoint = (i64, i64);

/// Whether every cell whose closed square the segment touches is free; for two ends in one cell, whether that cell is.
pub fn is_clear(space: &FreeSpace, from: LatticePoint, to: LatticePoint) -> bool {
    let cell_of = |(x, y): LatticePoint| (x.div_euclid(STEPS), y.div_euclid(STEPS));
    let is_free = |(column, row): (i64, i64)| space.is_free(Cell::new(column as i32, row as i32));
    if cell_of(from) == cell_of(to) {
        return is_free(cell_of(from));
    }
    let low = cell_of((from.0.min(to.0) - STEPS, from.1.min(to.1) - STEPS));
    let high = cell_of((from.0.max(to.0) + STEPS, from.1.max(to.1) + STEPS));
    (low.0..=high.0)
        .flat_map(|column| (low.1..=high.1).map(move |row| (column, row)))
        .all(|cell| !touches(cell, from, to) || is_free(cell))
}

fn touches((column, row): (i64, i64), from: LatticePoint, to: LatticePoint) -> bool {
    let (left, bottom) = (column * STEPS, row * STEPS);
    let (right, top) = (left + STEPS, bottom + STEPS);
    let boxes_meet = from.0.min(to.0) <= right
        && from.0.max(to.0) >= left
        && from.1.min(to.1) <= top
        && from.1.max(to.1) >= bottom;
    let side = |(x, y): LatticePoint| {
        (i128::from(to.0 - from.0) * i128::from(y - from.1)
            - i128::from(to.1 - from.1) * i128::from(x - from.0))
        .signum()
    };
    let sides = [(left, bottom), (right, bottom), (left, top), (right, top)].map(side);
    let is_split = !(sides.iter().all(|&side| side > 0) || sides.iter().all(|&side| side < 0));
    boxes_meet && is_split
}
