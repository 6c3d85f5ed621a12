//! Line of sight: whether a straight segment stays on free cells.

use crate::geometry::Point;
use crate::map::{BitGrid, FreeSpace};

/// Distance at which a segment touches a cell, in cells: far above rounding errors (1e-11 on grids of 32,767 cells), far
/// below any relevant length.
const TOUCH: f64 = 1e-9;

/// Fractions of a segment, in sixteenths, in an order that halves the gaps.
const PROBES: [f64; 15] = [
    0.5, 0.25, 0.75, 0.125, 0.375, 0.625, 0.875, 0.0625, 0.1875, 0.3125, 0.4375, 0.5625, 0.6875,
    0.8125, 0.9375,
];

/// Shortest segment that is probed before the full check, cells.
const MIN_PROBED_CELLS: f64 = 32.0;

/// Whether every cell that the segment touches is free. This includes cells touched only at a corner or edge, so a segment
/// through a grid corner needs all four adjacent cells. Rounding errors are on the safe side. A segment with an end outside
/// the grid, or that is not finite, is not clear.
///
/// Two points in the same free cell are always mutually visible, since the cell's closed square is clear.
#[must_use]
pub fn is_clear(space: &FreeSpace, from: &Point, to: &Point) -> bool {
    let frame = space.frame();
    has_line_of_sight(space, &frame.to_cell_units(from), &frame.to_cell_units(to))
}

/// Computes [`is_clear`] for ends in cell units.
pub(super) fn has_line_of_sight(space: &FreeSpace, a: &Point, b: &Point) -> bool {
    obstruction(space, a, b).is_none()
}

/// The approximate fraction of the segment from `a` to `b` at which it is blocked; none if it is clear.
pub(super) fn obstruction(space: &FreeSpace, a: &Point, b: &Point) -> Option<f64> {
    let frame = space.frame();
    let (Some(one), Some(other)) = (frame.cell_at_units(a), frame.cell_at_units(b)) else {
        return Some(0.0);
    };
    if one == other {
        return (!space.is_free(one)).then_some(0.0);
    }
    blocked_probe(space, a, b).or_else(|| first_blocked(space, a, b))
}

/// Whether the point at a fraction of the segment, 0 to 1, lies in a cell that is not free. Both ends must lie inside the
/// grid.
#[inline]
pub(super) fn is_blocked_at(space: &FreeSpace, a: &Point, b: &Point, fraction: f64) -> bool {
    let at = a + (b - a) * fraction;
    let (free, _) = space.bits();
    !free.at(free.position(at.x as i32, at.y as i32))
}

/// A probed fraction at which a long segment is blocked, if any. Most blocked segments cross large obstacles, which a few
/// probes detect faster than the full check.
fn blocked_probe(space: &FreeSpace, a: &Point, b: &Point) -> Option<f64> {
    let is_blocked = |&fraction: &f64| is_blocked_at(space, a, b, fraction);
    let whole = b - a;
    let length = whole.x.abs().max(whole.y.abs());
    (length >= MIN_PROBED_CELLS).then(|| PROBES.into_iter().find(is_blocked)).flatten()
}

/// Checks the touched cells line by line: along rows, or along columns for a steep segment. This gives few lines, each read
/// 64 cells at once. Both ends are in cell units, inside the grid.
fn first_blocked(space: &FreeSpace, a: &Point, b: &Point) -> Option<f64> {
    let (rows, columns) = space.bits();
    let whole = b - a;
    if whole.x.abs() >= whole.y.abs() {
        first_blocked_along(rows, (a.x, a.y), (b.x, b.y))
    } else {
        first_blocked_along(columns, (a.y, a.x), (b.y, b.x))
    }
}

/// The approximate fraction of a segment at which it touches an unset cell; none if it touches none. Each end has a
/// coordinate along the lines of the bit grid and one across them.
fn first_blocked_along(bits: &BitGrid, a: (f64, f64), b: (f64, f64)) -> Option<f64> {
    let (low, high) = if a.1 <= b.1 { (a, b) } else { (b, a) };
    let lines = cell_of(low.1 - TOUCH)..=cell_of(high.1 + TOUCH);
    let rise = high.1 - low.1;
    if rise <= TOUCH || lines.start() == lines.end() {
        let from = cell_of(low.0.min(high.0) - TOUCH);
        let to = cell_of(low.0.max(high.0) + TOUCH);
        let are_clear = lines.into_iter().all(|line| bits.all_set_in_row(line, from..=to));
        return (!are_clear).then_some(0.5);
    }
    let run = (high.0 - low.0) / rise;
    let along = |at: f64| low.0 + (at.clamp(low.1, high.1) - low.1) * run;
    // The part of the segment within a line, and the cells that it covers.
    let is_blocked = |&line: &i32| {
        let enters = along(f64::from(line) - TOUCH);
        let leaves = along(f64::from(line + 1) + TOUCH);
        let from = cell_of(enters.min(leaves) - TOUCH);
        let to = cell_of(enters.max(leaves) + TOUCH);
        !bits.all_set_in_row(line, from..=to)
    };
    let line = lines.into_iter().find(is_blocked)?;
    let fraction = ((f64::from(line) + 0.5 - low.1) / rise).clamp(0.0, 1.0);
    Some(if a.1 <= b.1 { fraction } else { 1.0 - fraction })
}

/// Rounds down, for values within the range of cells. `f64::floor` is a library call on baseline processors.
#[inline]
fn cell_of(at: f64) -> i32 {
    let towards_zero = at as i32;
    towards_zero - i32::from(f64::from(towards_zero) > at)
}
