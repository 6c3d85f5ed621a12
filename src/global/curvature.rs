//! Curvature of splines, to compare with the limits of the base (paper, eqs. 10-12).

use super::bspline::{Basis, CHORD_TURN_RAD, MAX_DEGREE, Segment};
use crate::geometry::{Point, Vector};

/// Points nearer than this are equal, metres: far below a cell, far above rounding errors.
const SAME_M: f64 = 1e-6;
/// Sine of the largest angle at which control points count as collinear.
const COLLINEAR_SINE: f64 = 1e-9;
/// Pieces of a curved segment, equal in the parameter, and therefore shortest where the curvature is largest.
const PIECES: usize = 64;

/// A uniform B-spline, the curve of a smoothed path. Where at least as many inner control points as its degree coincide, it
/// passes through them and is straight on both sides: a corner, unless it is collinear.
#[derive(Clone, Debug, PartialEq)]
pub struct Spline {
    degree: usize,
    control: Vec<Point>,
}

/// The curvature of a curve along its length.
#[derive(Clone, Debug, PartialEq)]
pub struct Curvature {
    /// Number of sharp corners, where the heading changes at once by more than 0.04 rad, the tolerance of a chord. The robot
    /// must turn in place there.
    pub sharp_turns: usize,
    /// Length of each piece, metres, and its largest curvature, 1/m.
    pieces: Vec<(f64, f64)>,
}

impl Spline {
    /// Creates a spline with control points in metres, in the map frame. A curve needs more points than the degree.
    ///
    /// # Panics
    /// If the degree is not 1 to 9.
    #[must_use]
    pub fn new(degree: usize, control: Vec<Point>) -> Self {
        assert!((1..=MAX_DEGREE).contains(&degree), "the degree of a spline is 1 to 9");
        Self { degree, control }
    }

    /// Creates a spline of degree one: straight lines between points.
    #[must_use]
    pub fn polyline(points: &[Point]) -> Self {
        Self::new(1, points.to_vec())
    }

    /// The distinct control points, each with its multiplicity.
    fn places(&self) -> Vec<(Point, usize)> {
        let mut places: Vec<(Point, usize)> = Vec::new();
        for &point in &self.control {
            match places.last_mut() {
                Some((place, count)) if (point - *place).norm() <= SAME_M => *count += 1,
                _ => places.push((point, 1)),
            }
        }
        places
    }
}

impl Curvature {
    /// Computes the curvature of consecutive splines. A change of heading between two of them counts as a corner.
    #[must_use]
    pub fn of<'a>(splines: impl IntoIterator<Item = &'a Spline>) -> Self {
        let (mut sharp_turns, mut pieces) = (0, Vec::new());
        let mut arrival: Option<Vector> = None;
        for spline in splines {
            let places = spline.places();
            let corners = places.windows(3).filter(|triple| {
                let [(from, _), (here, count), (to, _)] = triple else {
                    return false;
                };
                *count >= spline.degree && is_corner(&(here - from), &(to - here))
            });
            sharp_turns += corners.count();
            if let [(first, _), (second, _), ..] = places[..] {
                let departure = second - first;
                sharp_turns += usize::from(arrival.is_some_and(|it| is_corner(&it, &departure)));
            }
            if let [.., (before, _), (last, _)] = places[..] {
                arrival = Some(last - before);
            }
            let basis = Basis::new(spline.degree);
            let windows = spline.control.windows(spline.degree + 1);
            pieces.extend(windows.flat_map(|control| pieces_of(&basis, control)));
        }
        Self { sharp_turns, pieces }
    }

    /// The largest curvature between the corners, 1/m; zero on a straight path.
    #[must_use]
    pub fn max_per_m(&self) -> f64 {
        let curvatures = self.pieces.iter().map(|&(_, curvature)| curvature);
        curvatures.fold(0.0, f64::max)
    }

    /// The fraction of the length with a curvature of at most a limit, 1/m: 0 to 1. Corners have no length.
    #[must_use]
    pub fn fraction_within(&self, limit_per_m: f64) -> f64 {
        let length_m = |most: f64| -> f64 {
            let within = self.pieces.iter().filter(|piece| piece.1 <= most);
            within.map(|piece| piece.0).sum()
        };
        let whole_m = length_m(f64::INFINITY);
        if whole_m > 0.0 { length_m(limit_per_m) / whole_m } else { 1.0 }
    }
}

fn is_corner(before: &Vector, after: &Vector) -> bool {
    libm::atan2(before.perp(after), before.dot(after)).abs() > CHORD_TURN_RAD
}

/// The pieces of the segment with these control points: length and largest curvature.
fn pieces_of(basis: &Basis, control: &[Point]) -> Vec<(f64, f64)> {
    let segment = Segment::new(basis, control);
    let at = |step: usize| segment.point(step as f64 / PIECES as f64);
    if is_straight(control) {
        return vec![((at(PIECES) - at(0)).norm(), 0.0)];
    }
    let bend = |half_step: usize| segment.curvature(half_step as f64 / (2 * PIECES) as f64);
    (0..PIECES)
        .map(|step| {
            let bends = [bend(2 * step), bend(2 * step + 1), bend(2 * step + 2)];
            let greatest = bends.into_iter().fold(0.0, f64::max);
            ((at(step + 1) - at(step)).norm(), greatest)
        })
        .collect()
}

/// Whether control points are collinear, up to rounding.
fn is_straight(control: &[Point]) -> bool {
    let mut last: Option<Vector> = None;
    for pair in control.windows(2) {
        let step = pair[1] - pair[0];
        if step.norm() <= SAME_M {
            continue;
        }
        let is_bent =
            |last: Vector| last.perp(&step).abs() > COLLINEAR_SINE * last.norm() * step.norm();
        if last.is_some_and(is_bent) {
            return false;
        }
        last = Some(step);
    }
    true
}
