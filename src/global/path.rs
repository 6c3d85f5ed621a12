//! A polyline with arc lengths.

use core::ops::Range;

use crate::geometry::{Point, Vector, bearing, wrap_angle};

/// Smallest change of heading that counts as a turn, radians: 5 degrees.
const MIN_TURN_RAD: f64 = 0.087_266_462_599_716_48;

/// Points joined by straight segments, metres in the map frame. Adjacent points differ; there is at least one.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    points: Vec<Point>,
    /// Arc length at each point.
    arcs_m: Vec<f64>,
}

/// The point of a path that is nearest to a given point.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Projection {
    /// Arc length of that point, metres.
    pub arc_m: f64,
    /// Distance between the two, metres.
    pub distance_m: f64,
    /// The point on the path.
    pub point: Point,
}

impl Path {
    /// Creates a path through points and drops repeated ones. Lengths and places on a path mean nothing if a point is not finite.
    ///
    /// # Panics
    /// Panics if there is no point.
    #[must_use]
    pub fn new(mut points: Vec<Point>) -> Self {
        assert!(!points.is_empty(), "a path has at least one point");
        points.dedup();
        let mut arcs_m = Vec::with_capacity(points.len());
        let mut arc_m = 0.0;
        arcs_m.push(arc_m);
        for pair in points.windows(2) {
            arc_m += (pair[1] - pair[0]).norm();
            arcs_m.push(arc_m);
        }
        Self { points, arcs_m }
    }

    /// The points.
    #[must_use]
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// Length, metres.
    #[must_use]
    pub fn length_m(&self) -> f64 {
        self.arcs_m.last().copied().unwrap_or(0.0)
    }

    /// Number of inner points at which the heading changes by more than 5 degrees: the paper's inflection points (Table 2).
    #[must_use]
    pub fn turns(&self) -> usize {
        let change = |triple: &[Point]| {
            wrap_angle(bearing(&triple[1], &triple[2]) - bearing(&triple[0], &triple[1])).abs()
        };
        self.points.windows(3).filter(|triple| change(triple) > MIN_TURN_RAD).count()
    }

    /// The point at an arc length, clamped to the path.
    #[must_use]
    pub fn point_at(&self, arc_m: f64) -> Point {
        let after = self.arcs_m.partition_point(|&arc| arc <= arc_m);
        if after == 0 {
            return self.points[0];
        }
        let Some(next) = self.points.get(after) else {
            return self.points[self.points.len() - 1];
        };
        let (from, to) = (self.arcs_m[after - 1], self.arcs_m[after]);
        let fraction = (arc_m - from) / (to - from);
        self.points[after - 1] + (next - self.points[after - 1]) * fraction
    }

    /// Unit tangent at an arc length; at a vertex, that of the segment before it; zero on a path of one point.
    #[must_use]
    pub fn direction_at(&self, arc_m: f64) -> Vector {
        let last = self.points.len() - 1;
        let end = self.arcs_m.partition_point(|&arc| arc < arc_m);
        let end = end.clamp(1.min(last), last);
        let segment = self.points[end] - self.points[end.saturating_sub(1)];
        let length = segment.norm();
        if length <= 0.0 { Vector::ZERO } else { segment / length }
    }

    /// Points at equal spacing of at most `spacing_m`, above zero, both ends included.
    pub fn samples(&self, spacing_m: f64) -> impl Iterator<Item = Point> + '_ {
        let count = (self.length_m() / spacing_m).ceil().max(1.0);
        (0..=count as usize).map(move |index| self.point_at(self.length_m() * index as f64 / count))
    }

    /// The nearest point of the whole path; ties go to the earliest.
    #[must_use]
    pub fn project(&self, point: &Point) -> Projection {
        self.project_within(point, 0.0..self.length_m())
    }

    /// The nearest point between two arc lengths; ties go to the earliest. The range is clamped to the path.
    #[must_use]
    pub fn project_within(&self, point: &Point, range_m: Range<f64>) -> Projection {
        let length = self.length_m();
        // Unlike `clamp`, these have a result for a length that is no number.
        let begin = range_m.start.max(0.0).min(length);
        let end = range_m.end.max(begin).min(length);
        let mut best = self.projection(point, begin);
        let first = self.arcs_m.partition_point(|&arc| arc <= begin).max(1);
        for index in first..self.points.len() {
            let (from_m, to_m) = (self.arcs_m[index - 1], self.arcs_m[index]);
            if from_m > end {
                break;
            }
            if to_m.is_nan() || to_m <= from_m {
                // The arc lengths of two close points are equal; both are ends of longer segments.
                continue;
            }
            let from = self.points[index - 1];
            let along = (self.points[index] - from) / (to_m - from_m);
            let arc_m = (from_m + along.dot(&(point - from))).clamp(from_m, to_m);
            let found = self.projection(point, arc_m.clamp(begin, end));
            if found.distance_m < best.distance_m {
                best = found;
            }
        }
        best
    }

    fn projection(&self, point: &Point, arc_m: f64) -> Projection {
        let on_path = self.point_at(arc_m);
        Projection { arc_m, distance_m: (point - on_path).norm(), point: on_path }
    }
}
