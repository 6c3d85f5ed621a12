//! The cells that a convex shape keeps free, and the shapes that a moving body sweeps.

use crate::geometry::{Point, Vector};
use crate::map::{BitGrid, Cell};
use crate::robot::Polygon;

/// A shape may be nearer than its margin by this, cells: rounding, and anchors that are moved into their cell.
const TOLERANCE: f64 = 1e-4;
/// Largest turn whose swept shape is one hull, radians: its overhang beyond the true shape stays below a millimetre.
pub(super) const MAX_TURN_RAD: f64 = 0.21;
/// Poses within such a turn.
const TURN_POSES: u32 = 4;

/// Rows of cells that must be free, relative to a cell.
#[derive(Clone, Debug)]
pub(super) struct Stencil {
    /// Row, first and last column.
    rows: Vec<(i32, i32, i32)>,
}

impl Stencil {
    /// The cells whose square is nearer than a margin to a convex shape, all in cells.
    pub fn new(shape: &Polygon, margin: f64) -> Self {
        let corners = shape.corners();
        let least = corners.iter().fold(corners[0], |least, corner| least.min(corner));
        let most = corners.iter().fold(corners[0], |most, corner| most.max(corner));
        let first = |least: f64| (least - margin).floor() as i32 - 1;
        let last = |most: f64| (most + margin).floor() as i32 + 1;
        let reach = margin - TOLERANCE;
        let is_near = |column: i32, row: i32| {
            let corner = Point::new(f64::from(column), f64::from(row));
            shape.distance_to_unit_square(&corner) < reach
        };
        let mut rows = Vec::new();
        for row in first(least.y)..=last(most.y) {
            // The shape is convex: the near cells of a row are joined.
            let mut columns = first(least.x)..=last(most.x);
            let Some(left) = columns.find(|&column| is_near(column, row)) else {
                continue;
            };
            let right = columns.rev().find(|&column| is_near(column, row)).unwrap_or(left);
            rows.push((row, left, right));
        }
        Self { rows }
    }

    /// Whether all its cells are free, relative to a cell. Cells outside the grid are not.
    pub fn is_clear(&self, free: &BitGrid, cell: Cell) -> bool {
        self.rows.iter().all(|&(row, left, right)| {
            free.all_set_in_row(cell.row + row, cell.column + left..=cell.column + right)
        })
    }
}

/// A convex body around the origin, in cells.
#[derive(Clone, Debug)]
pub(super) struct Body(Polygon);

impl Body {
    /// The convex hull of a polygon in metres, on cells of this size.
    pub fn new(polygon: &Polygon, resolution_m: f64) -> Self {
        let in_cells =
            |corner: &Point| Point::new(corner.x / resolution_m, corner.y / resolution_m);
        Self(Polygon::convex_hull(polygon.corners().iter().map(in_cells).collect()))
    }

    /// The shape at a heading, radians, that is moved from a place by a displacement.
    pub fn moved(&self, from: Point, angle: f64, by: Vector) -> Polygon {
        let turn = libm::sincos(angle);
        let at = |place: Point| {
            self.0.corners().iter().map(move |corner| place + corner.to_vector().rotated(turn))
        };
        Polygon::convex_hull(at(from).chain(at(from + by)).collect())
    }

    /// A shape that contains the body at a place at all headings from one on by a turn of at most [`MAX_TURN_RAD`].
    pub fn turned(&self, place: Point, from: f64, turn: f64) -> Polygon {
        // The tangents of a corner's arc at two poses meet this much farther out.
        let step = turn / f64::from(TURN_POSES);
        let outwards = 1.0 / libm::cos(step / 2.0);
        let exact = (0..=TURN_POSES).map(|pose| (1.0, f64::from(pose)));
        let between = (0..TURN_POSES).map(|pose| (outwards, f64::from(pose) + 0.5));
        let corners = exact.chain(between).flat_map(|(scale, pose)| {
            let turn = libm::sincos(from + step * pose);
            let corner = move |corner: &Point| place + corner.to_vector().rotated(turn) * scale;
            self.0.corners().iter().map(corner)
        });
        Polygon::convex_hull(corners.collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turned_body_contains_every_pose_and_little_more() {
        let body = Body::new(&Polygon::rectangle(0.7, 0.5).expect("a rectangle"), 0.05);
        let place = Point::new(3.25, -1.5);
        let swept = body.turned(place, 0.4, MAX_TURN_RAD);
        let poses: Vec<Polygon> = (0..=400)
            .map(|step| {
                let angle = 0.4 + MAX_TURN_RAD * f64::from(step) / 400.0;
                body.moved(place, angle, Vector::ZERO)
            })
            .collect();
        for corner in poses.iter().flat_map(Polygon::corners) {
            assert!(swept.signed_distance(corner) < 1e-9, "{corner:?}");
        }
        let over = |corner: &Point| {
            let distance = |pose: &Polygon| pose.distance(corner);
            poses.iter().map(distance).fold(f64::INFINITY, f64::min)
        };
        let most = swept.corners().iter().map(over).fold(0.0, f64::max);
        assert!(most < 0.02, "{most} cells");
    }

    #[test]
    fn stencil_has_exactly_the_cells_within_the_margin() {
        let body = Body::new(&Polygon::rectangle(0.7, 0.5).expect("a rectangle"), 0.05);
        for (index, angle) in [0.0, 0.32, 0.79, 2.2].into_iter().enumerate() {
            let place = Point::new(0.5 * (index % 2) as f64, 0.5);
            let shape = body.moved(place, angle, Vector::new(1.5, 0.5));
            let stencil = Stencil::new(&shape, 1.0);
            for (column, row) in
                (-30..30).flat_map(|row| (-30..30).map(move |column| (column, row)))
            {
                let corner = Point::new(f64::from(column), f64::from(row));
                let is_near = shape.distance_to_unit_square(&corner) < 1.0 - TOLERANCE;
                let is_listed = stencil
                    .rows
                    .iter()
                    .any(|&(at, left, right)| at == row && (left..=right).contains(&column));
                assert_eq!(is_near, is_listed, "{column} {row} at {angle}");
            }
        }
    }
}
