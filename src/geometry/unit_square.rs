//! Squared distances to a closed unit square, which is given by its lower left corner: a cell of a grid, in cells.

use super::{Point, nearest_on_segment};

/// Squared distance from a point; zero inside.
pub(crate) fn point_to_unit_square(point: &Point, corner: &Point) -> f64 {
    let beyond = |at: f64, low: f64| (low - at).max(at - low - 1.0).max(0.0);
    let (dx, dy) = (beyond(point.x, corner.x), beyond(point.y, corner.y));
    dx * dx + dy * dy
}

/// Squared distance from a segment; zero where they touch.
pub(crate) fn segment_to_unit_square(from: &Point, to: &Point, corner: &Point) -> f64 {
    if meets_unit_square(from, to, corner) {
        return 0.0;
    }
    let to_segment = |(right, up): (f64, f64)| {
        let point = Point::new(corner.x + right, corner.y + up);
        (point - nearest_on_segment(from, to, &point)).norm_squared()
    };
    let to_ends = point_to_unit_square(from, corner).min(point_to_unit_square(to, corner));
    [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)]
        .map(to_segment)
        .into_iter()
        .fold(to_ends, f64::min)
}

/// Whether a segment and the square have a point in common: the part of the segment within both slabs is not empty.
fn meets_unit_square(from: &Point, to: &Point, corner: &Point) -> bool {
    let (mut first, mut last) = (0.0_f64, 1.0_f64);
    for (start, end, low) in [(from.x, to.x, corner.x), (from.y, to.y, corner.y)] {
        let along = end - start;
        if along == 0.0 {
            if start < low || start > low + 1.0 {
                return false;
            }
            continue;
        }
        let (enters, leaves) = ((low - start) / along, (low + 1.0 - start) / along);
        first = first.max(enters.min(leaves));
        last = last.min(enters.max(leaves));
    }
    first <= last
}
