//! A polygon in the plane, and its distances to points and grid cells.

use serde::{Deserialize, Serialize};

use super::RobotError;
use crate::geometry::{Point, is_in_polygon, nearest_on_segment, segment_to_unit_square};

/// Largest absolute coordinate of a corner, metres.
const MAX_COORDINATE_M: f64 = 100.0;
/// Largest number of corners.
const MAX_CORNERS: usize = 256;
/// Least area, square metres.
const MIN_AREA_M2: f64 = 1e-6;

/// The outline of a body: corners in order, at least three. The last corner is joined to the first.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<Point>", into = "Vec<Point>")]
pub struct Polygon(Vec<Point>);

impl Polygon {
    /// Creates a polygon from its corners, metres, in either direction.
    ///
    /// # Errors
    /// Returns an error for fewer than 3 or more than 256 corners, a coordinate that is not finite or beyond 100 m, edges that
    /// cross, or corners that enclose no area.
    pub fn new(corners: Vec<Point>) -> Result<Self, RobotError> {
        let is_near =
            |point: &Point| point.x.abs() <= MAX_COORDINATE_M && point.y.abs() <= MAX_COORDINATE_M;
        let reason = if !(3..=MAX_CORNERS).contains(&corners.len()) {
            "it has fewer than 3 or more than 256 corners"
        } else if !corners.iter().all(is_near) {
            "a coordinate is not finite or beyond 100 m"
        } else {
            let polygon = Self(corners);
            if polygon.crosses_itself() {
                "two of its edges cross: give the corners in their order around the body"
            } else if polygon.signed_area_m2().abs() < MIN_AREA_M2 {
                "its corners enclose no area"
            } else {
                return Ok(polygon);
            }
        };
        Err(RobotError::BadBody { reason })
    }

    /// Creates a rectangle around the origin from its length along x and its width along y, metres.
    ///
    /// # Errors
    /// As [`Self::new`], and when a length is not above zero.
    pub fn rectangle(length_m: f64, width_m: f64) -> Result<Self, RobotError> {
        if !(length_m > 0.0 && width_m > 0.0) {
            return Err(RobotError::BadBody { reason: "a side is not above zero" });
        }
        Self::new(rectangle_corners(length_m, width_m))
    }

    /// The corners, at least three.
    #[must_use]
    pub fn corners(&self) -> &[Point] {
        &self.0
    }

    /// The same polygon with each corner moved: to another frame or unit.
    #[must_use]
    pub(crate) fn mapped(&self, to: impl Fn(&Point) -> Point) -> Self {
        Self(self.0.iter().map(to).collect())
    }

    /// The lower left and upper right corners of the box around it, with sides along the axes.
    pub(crate) fn bounds(&self) -> (Point, Point) {
        let with = |limit: fn(f64, f64) -> f64| {
            let join = |one: Point, other: &Point| {
                Point::new(limit(one.x, other.x), limit(one.y, other.y))
            };
            self.0[1..].iter().fold(self.0[0], join)
        };
        (with(f64::min), with(f64::max))
    }

    /// The edges, each from a corner to the next.
    pub(crate) fn edges(&self) -> impl Iterator<Item = (&Point, &Point)> {
        let closing = self.0.last().into_iter().zip(self.0.first());
        self.0.iter().zip(&self.0[1..]).chain(closing)
    }

    /// Whether two of its edges cross. Edges that only touch, as those with a common corner, do not.
    fn crosses_itself(&self) -> bool {
        let separates = |(from, to): (&Point, &Point), (one, other): (&Point, &Point)| {
            let side = |point: &Point| (to - from).perp(&(point - from));
            side(one) * side(other) < 0.0
        };
        self.edges()
            .any(|edge| self.edges().any(|other| separates(edge, other) && separates(other, edge)))
    }

    /// Whether a point is inside, by the even-odd rule.
    #[must_use]
    pub fn contains(&self, point: &Point) -> bool {
        is_in_polygon(&self.0, point)
    }

    /// The point of the outline nearest to a point.
    #[must_use]
    pub fn nearest_on_outline(&self, point: &Point) -> Point {
        let squared = |at: &Point| (point - at).norm_squared();
        self.edges()
            .map(|(from, to)| nearest_on_segment(from, to, point))
            .min_by(|one, other| squared(one).total_cmp(&squared(other)))
            .unwrap_or(*point)
    }

    /// Distance from a point to the polygon, in the unit of its corners; zero inside.
    #[must_use]
    pub fn distance(&self, point: &Point) -> f64 {
        if self.contains(point) { 0.0 } else { self.distance_to_outline(point) }
    }

    /// Distance from a point to the outline.
    fn distance_to_outline(&self, point: &Point) -> f64 {
        let squared = |(from, to): (&Point, &Point)| {
            (point - nearest_on_segment(from, to, point)).norm_squared()
        };
        libm::sqrt(self.edges().map(squared).fold(f64::INFINITY, f64::min))
    }

    /// Signed distance from a point to the outline, in the unit of the corners: negative inside.
    #[must_use]
    pub fn signed_distance(&self, point: &Point) -> f64 {
        let distance = self.distance_to_outline(point);
        if self.contains(point) { -distance } else { distance }
    }

    /// Signed distance to a segment, in the unit of the corners: that of its nearer end where an end is inside, zero where the
    /// segment only crosses the outline.
    #[must_use]
    pub fn signed_distance_to_segment(&self, from: &Point, to: &Point) -> f64 {
        let nearer_end = self.signed_distance(from).min(self.signed_distance(to));
        if nearer_end <= 0.0 {
            return nearer_end;
        }
        let to_edge = |(start, end): (&Point, &Point)| {
            if segments_cross(from, to, start, end) {
                return 0.0;
            }
            // Two segments that do not cross are nearest at an end of one of them. The ends of the given one are compared above.
            let corner_to_segment = (start - nearest_on_segment(from, to, start)).norm();
            corner_to_segment.min(nearer_end)
        };
        self.edges().map(to_edge).fold(nearer_end, f64::min)
    }

    /// Distance to a closed unit square, given by its lower left corner, in the unit of the corners; zero where they overlap.
    #[must_use]
    pub fn distance_to_unit_square(&self, corner: &Point) -> f64 {
        let squared = self
            .edges()
            .map(|(from, to)| segment_to_unit_square(from, to, corner))
            .fold(f64::INFINITY, f64::min);
        // A square that no edge touches may still be inside.
        if squared > 0.0 && self.contains(corner) { 0.0 } else { squared.sqrt() }
    }

    /// Whether the corners follow each other counter-clockwise.
    pub(super) fn is_counter_clockwise(&self) -> bool {
        self.signed_area_m2() > 0.0
    }

    /// The area; below zero where the corners follow each other clockwise.
    pub(super) fn signed_area_m2(&self) -> f64 {
        let twice = |(from, to): (&Point, &Point)| from.to_vector().perp(&to.to_vector());
        self.edges().map(twice).sum::<f64>() / 2.0
    }
}

/// Whether two segments cross: each has its ends on different sides of the other.
fn segments_cross(from: &Point, to: &Point, start: &Point, end: &Point) -> bool {
    let separates = |from: &Point, to: &Point, one: &Point, other: &Point| {
        let along = to - from;
        (along.perp(&(one - from)) > 0.0) != (along.perp(&(other - from)) > 0.0)
    };
    separates(from, to, start, end) && separates(start, end, from, to)
}

fn rectangle_corners(length: f64, width: f64) -> Vec<Point> {
    let (x, y) = (length / 2.0, width / 2.0);
    [(x, y), (x, -y), (-x, -y), (-x, y)].map(|(x, y)| Point::new(x, y)).to_vec()
}

impl Default for Polygon {
    /// The body of a small tracked base: 0.7 by 0.5 m.
    fn default() -> Self {
        Self(rectangle_corners(0.7, 0.5))
    }
}

impl TryFrom<Vec<Point>> for Polygon {
    type Error = RobotError;

    fn try_from(corners: Vec<Point>) -> Result<Self, RobotError> {
        Self::new(corners)
    }
}

impl From<Polygon> for Vec<Point> {
    fn from(polygon: Polygon) -> Self {
        polygon.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of 2 m with a notch from the right to its middle.
    fn notched() -> Polygon {
        let corners = [
            (-1.0, -1.0),
            (1.0, -1.0),
            (1.0, -0.2),
            (0.0, 0.0),
            (1.0, 0.2),
            (1.0, 1.0),
            (-1.0, 1.0),
        ];
        Polygon::new(corners.map(|(x, y)| Point::new(x, y)).to_vec()).expect("a polygon")
    }

    #[test]
    fn edges_that_cross_are_an_error() {
        let polygon = |corners: &[(f64, f64)]| {
            Polygon::new(corners.iter().map(|&(x, y)| Point::new(x, y)).collect())
        };
        let crossed = [(0.3, 0.3), (0.3, -0.3), (-0.3, -0.3), (-0.1, 0.0), (0.6, 0.0), (-0.3, 0.3)];
        let error = polygon(&crossed).expect_err("edges cross").to_string();
        assert!(error.contains("two of its edges cross"), "{error}");
        let bow_tie = [(0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)];
        assert!(polygon(&bow_tie).is_err());
        // An L, a triangle, and a rectangle with a corner given twice.
        for shape in [
            &[(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)][..],
            &[(0.0, 0.0), (2.0, 0.0), (1.0, 1.0)],
            &[(0.0, 0.0), (2.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)],
        ] {
            assert!(polygon(shape).is_ok(), "{shape:?}");
        }
    }

    #[test]
    fn signed_distance_is_negative_inside() {
        let shape = notched();
        for (x, y, expected) in
            [(0.0, 1.5, 0.5), (-0.7, 0.0, -0.3), (2.0, 2.0, 2_f64.sqrt()), (0.0, 0.0, 0.0)]
        {
            let distance = shape.signed_distance(&Point::new(x, y));
            assert!((distance - expected).abs() < 1e-12, "{distance} at {x}, {y}");
        }
        assert!(shape.signed_distance(&Point::new(0.9, 0.0)) > 0.0, "in the notch");
    }

    #[test]
    fn segment_is_as_near_as_its_nearest_point_and_crosses_at_zero() {
        let shape = notched();
        let distance = |from: (f64, f64), to: (f64, f64)| {
            shape.signed_distance_to_segment(&Point::new(from.0, from.1), &Point::new(to.0, to.1))
        };
        // Past a corner, with both ends farther away than the corner.
        let past = distance((0.5, 2.0), (2.0, 0.5));
        assert!((past - 0.5 / 2_f64.sqrt()).abs() < 1e-12, "{past}");
        // Through the whole shape within one step, and into it.
        assert_eq!(distance((-2.0, 0.5), (2.0, 0.5)), 0.0);
        assert!((distance((-2.0, 0.0), (-0.6, 0.0)) + 0.4).abs() < 1e-12);
        // A segment that is a point.
        assert!((distance((0.0, 1.5), (0.0, 1.5)) - 0.5).abs() < 1e-12);
    }
}
