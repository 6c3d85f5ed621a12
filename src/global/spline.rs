//! Smoothing by a uniform B-spline (paper, section 3.2.3, eqs. 24-26) with verified clearance.
//!
//! With control points at the pruned vertices only, the printed method cuts the corners to which pruning moves the path, and
//! collides. Here each vertex has control points on both its edges, at first half an edge away. Where a chord of the curve
//! leaves the free cells, the control points of the vertices that shape it there move towards their vertex until it fits;
//! finally the vertex is kept sharp. All control points lie on the pruned path, so the curve is never longer.

use std::collections::BTreeSet;

use super::bspline::{Basis, Segment};
use super::curvature::Spline;
use super::line_of_sight::{has_line_of_sight, is_clear};
use super::path::Path;
use super::prune::merge_collinear;
use crate::geometry::{Point, nearest_on_segment};
use crate::map::FreeSpace;

/// Factor by which control points move towards a vertex whose curve does not fit.
const SHRINK: f64 = 0.75;
/// A vertex with control points nearer than this, in cells, is kept sharp.
const SHARP_CELLS: f64 = 0.25;
/// Points nearer than this are equal, metres.
const SAME_M: f64 = 1e-6;
/// Largest distance of a point on an edge, metres: above rounding errors, and below the precision of the clearance.
const ON_EDGE_M: f64 = 1e-10;

/// Smooths a path that is clear in `space` with a B-spline of a degree; returns it with the curve that it samples.
/// Both ends are kept exactly, and every chord is clear
/// in `space` or part of an edge of the path. The result is never longer than the path, up to rounding. A path without inner
/// points is returned as it is, and so is any path for a degree below two.
///
/// Chords stay within 3 mm and 0.04 rad of the curve, and a straight stretch has no inner points.
#[must_use]
pub fn smooth(space: &FreeSpace, path: &Path, degree: usize) -> (Path, Spline) {
    let vertices = path.points();
    let unchanged = || (path.clone(), Spline::polyline(vertices));
    if vertices.len() < 3 || degree < 2 {
        return unchanged();
    }
    let curve = Curve::fit(space, vertices, degree);
    let points = merge_collinear(&curve.points(vertices));
    // The fit has checked every chord; this verifies the points returned.
    let is_verified = |chord: &[Point]| {
        is_clear(space, &chord[0], &chord[1])
            || vertices.windows(2).any(|edge| is_part(edge, chord))
    };
    if points.windows(2).all(is_verified) {
        (Path::new(points), Spline::new(degree, curve.control))
    } else {
        unchanged()
    }
}

/// Whether both ends of a chord lie on an edge, up to rounding.
fn is_part(edge: &[Point], chord: &[Point]) -> bool {
    chord
        .iter()
        .all(|point| (point - nearest_on_segment(&edge[0], &edge[1], point)).norm() <= ON_EDGE_M)
}

/// A B-spline fitted to the vertices of a path.
struct Curve {
    degree: usize,
    basis: Basis,
    /// Control points. Both path ends occur as often as the degree, so that the curve starts and ends there. Each inner vertex
    /// has an equal number of points on both edges and the vertex itself: at least as many as the degree, so that a vertex
    /// with coincident points is passed through, straight on both sides.
    control: Vec<Point>,
    /// Distance from each vertex to its outermost control points, metres; zero for a sharp one.
    reach_m: Vec<f64>,
    /// For each segment, the sampled points after its first.
    samples: Vec<Vec<Point>>,
}

impl Curve {
    /// Fits the curve with the largest distances, vertex by vertex, whose chords are clear.
    fn fit(space: &FreeSpace, vertices: &[Point], degree: usize) -> Self {
        let mut curve = Self::widest(vertices, degree);
        let sharp_m = SHARP_CELLS * space.frame().resolution_m;
        let mut stale = vec![true; curve.control.len() - degree];
        loop {
            let mut tight = BTreeSet::new();
            for (segment, is_stale) in stale.iter_mut().enumerate() {
                if core::mem::take(is_stale) && !curve.sample(space, segment) {
                    tight.extend(curve.shaping_vertices(segment));
                }
            }
            tight.retain(|&vertex| curve.reach_m[vertex] > 0.0);
            if tight.is_empty() {
                return curve;
            }
            for vertex in tight {
                let reach_m = curve.reach_m[vertex] * SHRINK;
                curve.reach_m[vertex] = if reach_m < sharp_m { 0.0 } else { reach_m };
                let moved = curve.place(vertices, vertex);
                stale[(moved.start - degree)..moved.end.min(curve.control.len() - degree)]
                    .fill(true);
            }
        }
    }

    fn widest(vertices: &[Point], degree: usize) -> Self {
        let (start, goal) = (vertices[0], vertices[vertices.len() - 1]);
        let edges_m: Vec<f64> =
            vertices.windows(2).map(|edge| (edge[1] - edge[0]).norm()).collect();
        let half = |edges: &[f64]| edges[0].min(edges[1]) / 2.0;
        let reach_m =
            [&[0.0][..], &edges_m.windows(2).map(half).collect::<Vec<f64>>(), &[0.0]].concat();
        let inner = (vertices.len() - 2) * Self::per_vertex(degree);
        let mut control = vec![start; degree + inner];
        control.extend(core::iter::repeat_n(goal, degree));
        let samples = vec![Vec::new(); control.len() - degree];
        let mut curve = Self { degree, basis: Basis::new(degree), control, reach_m, samples };
        for vertex in 1..vertices.len() - 1 {
            curve.place(vertices, vertex);
        }
        curve
    }

    const fn per_vertex(degree: usize) -> usize {
        2 * (degree / 2) + 1
    }

    /// Moves the control points of an inner vertex to their positions and returns their indices.
    fn place(&mut self, vertices: &[Point], vertex: usize) -> core::ops::Range<usize> {
        let here = vertices[vertex];
        let towards = |other: Point| {
            let edge = other - here;
            edge / edge.norm() * self.reach_m[vertex]
        };
        let (back, on) = (towards(vertices[vertex - 1]), towards(vertices[vertex + 1]));
        let sides = self.degree / 2;
        let first = self.degree + (vertex - 1) * Self::per_vertex(self.degree);
        for step in 1..=sides {
            let fraction = step as f64 / sides as f64;
            self.control[first + sides - step] = here + back * fraction;
            self.control[first + sides + step] = here + on * fraction;
        }
        self.control[first + sides] = here;
        first..first + Self::per_vertex(self.degree)
    }

    /// Position of a control point along the path: twice its vertex, minus one on the edge before it, plus one after it.
    fn position(&self, control: usize) -> usize {
        let last = self.reach_m.len() - 1;
        let per_vertex = Self::per_vertex(self.degree);
        let inner = control.checked_sub(self.degree);
        let vertex = inner.map_or(0, |inner| (inner / per_vertex + 1).min(last));
        if self.reach_m[vertex] == 0.0 {
            return 2 * vertex;
        }
        let center = self.degree + (vertex - 1) * per_vertex + self.degree / 2;
        2 * vertex + usize::from(control > center) - usize::from(control < center)
    }

    /// The vertices strictly between the control points of a segment; without any, it lies on an edge.
    fn shaping_vertices(&self, segment: usize) -> core::ops::Range<usize> {
        let (first, last) = (segment, segment + self.degree);
        self.position(first) / 2 + 1..self.position(last).div_ceil(2)
    }

    /// Samples a segment again. Returns false if one of its chords is not clear.
    fn sample(&mut self, space: &FreeSpace, number: usize) -> bool {
        let segment = Segment::new(&self.basis, &self.control[number..=number + self.degree]);
        let frame = space.frame();
        let samples = &mut self.samples[number];
        samples.clear();
        let mut last = frame.to_cell_units(&segment.point(0.0));
        let mut is_clear = true;
        segment.chords(|point| {
            samples.push(point);
            let here = frame.to_cell_units(&point);
            is_clear = is_clear && has_line_of_sight(space, &last, &here);
            last = here;
        });
        is_clear
    }

    /// The whole curve, with the exact ends of the path.
    fn points(&self, vertices: &[Point]) -> Vec<Point> {
        let goal = vertices[vertices.len() - 1];
        let mut points = vec![vertices[0]];
        for &point in self.samples.iter().flatten() {
            let is_new = points.last().is_none_or(|last| (point - last).norm() > SAME_M);
            if is_new && (point - goal).norm() > SAME_M {
                points.push(point);
            }
        }
        points.push(goal);
        points
    }
}
