//! Whether a straight way between two points stays on free cells.

use crate::geometry::Point;
use crate::map::{BitGrid, FreeSpace};

/// A segment this near to a cell touches it, in cells: far above the rounding of the arithmetic here (1e-11 on grids
/// of 32,767 cells), far below anything that matters.
const TOUCH: f64 = 1e-9;

/// Sixteenths of a segment, each halving what the ones before it left.
const PROBES: [f64; 15] = [
    0.5, 0.25, 0.75, 0.125, 0.375, 0.625, 0.875, 0.0625, 0.1875, 0.3125, 0.4375, 0.5625, 0.6875,
    0.8125, 0.9375,
];

/// Segments of at least this many cells are probed before they are walked.
const PROBED_FROM: f64 = 32.0;

/// Whether every cell that the segment touches is free, cells that it only grazes included: so a segment through a
/// corner of the lattice needs all four cells around it, and no corner is cut. Exact on the safe side. A segment with
/// an end outside the grid, or one that is not finite, is not clear.
///
/// Two points in one free cell see each other even on its border: all of a free cell's closed square is clear.
#[must_use]
pub fn is_clear(space: &FreeSpace, from: &Point, to: &Point) -> bool {
    let frame = space.frame();
    sees(space, &frame.to_cell_units(from), &frame.to_cell_units(to))
}

/// [`is_clear`] for ends in cell units of the grid.
pub(super) fn sees(space: &FreeSpace, a: &Point, b: &Point) -> bool {
    obstruction(space, a, b).is_none()
}

/// What keeps [`sees`] from holding: about which share of the segment from `a` to `b` it is blocked.
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

/// Whether the point at a share of the segment, 0 to 1, lies in a cell that is not free; then the segment is not clear.
/// Both ends must lie inside the grid.
#[inline]
pub(super) fn is_blocked_at(space: &FreeSpace, a: &Point, b: &Point, share: f64) -> bool {
    let at = a + (b - a) * share;
    let (free, _) = space.bits();
    !free.at(free.position(at.x as i32, at.y as i32))
}

/// Some share at which a long segment lies in a cell that is not free. Most segments that are not clear run through much
/// rock, and a few points tell sooner than a walk along it.
fn blocked_probe(space: &FreeSpace, a: &Point, b: &Point) -> Option<f64> {
    let is_blocked = |&share: &f64| is_blocked_at(space, a, b, share);
    ((b - a).amax() >= PROBED_FROM)
        .then(|| PROBES.into_iter().find(is_blocked))
        .flatten()
}

/// Line by line, what the segment touches: along rows, or along columns where it is steep, so that there are few lines
/// and each is read 64 cells at once. Both ends in cell units, inside the grid.
fn first_blocked(space: &FreeSpace, a: &Point, b: &Point) -> Option<f64> {
    let (rows, columns) = space.bits();
    let whole = b - a;
    if whole.x.abs() >= whole.y.abs() {
        first_blocked_along(rows, (a.x, a.y), (b.x, b.y))
    } else {
        first_blocked_along(columns, (a.y, a.x), (b.y, b.x))
    }
}

/// About which share of the segment between two points, each a place along the lines of a grid of bits and one across
/// them, it touches what is not set; none when it does not.
fn first_blocked_along(bits: &BitGrid, a: (f64, f64), b: (f64, f64)) -> Option<f64> {
    let (low, high) = if a.1 <= b.1 { (a, b) } else { (b, a) };
    let lines = cell_of(low.1 - TOUCH)..=cell_of(high.1 + TOUCH);
    let rise = high.1 - low.1;
    if rise <= TOUCH || lines.start() == lines.end() {
        let from = cell_of(low.0.min(high.0) - TOUCH);
        let to = cell_of(low.0.max(high.0) + TOUCH);
        let are_clear = lines
            .into_iter()
            .all(|line| bits.all_set_in_row(line, from..=to));
        return (!are_clear).then_some(0.5);
    }
    let run = (high.0 - low.0) / rise;
    let along = |at: f64| low.0 + (at.clamp(low.1, high.1) - low.1) * run;
    // The part of the segment within a line, and the cells it spans.
    let is_blocked = |&line: &i32| {
        let enters = along(f64::from(line) - TOUCH);
        let leaves = along(f64::from(line + 1) + TOUCH);
        let from = cell_of(enters.min(leaves) - TOUCH);
        let to = cell_of(enters.max(leaves) + TOUCH);
        !bits.all_set_in_row(line, from..=to)
    };
    let line = lines.into_iter().find(is_blocked)?;
    let share = ((f64::from(line) + 0.5 - low.1) / rise).clamp(0.0, 1.0);
    Some(if a.1 <= b.1 { share } else { 1.0 - share })
}

/// The largest whole number not above another within the range of cells. The library's rounding is a call where a
/// processor need not know it.
#[inline]
fn cell_of(at: f64) -> i32 {
    let towards_zero = at as i32;
    towards_zero - i32::from(f64::from(towards_zero) > at)
}
