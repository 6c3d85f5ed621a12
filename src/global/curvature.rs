//! Curvature of splines, to compare with the limits of the base (paper, eqs. 10-12).

use super::bspline::{Basis, CHORD_TURN_RAD, Segment};
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
    /// Creates a spline of a degree of at least one; it has more control points than that, in metres in the map frame.
    pub(super) fn new(degree: usize, control: Vec<Point>) -> Self {
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

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::TAU;

    fn points(of: &[(f64, f64)]) -> Vec<Point> {
        of.iter().map(|&(x, y)| Point::new(x, y)).collect()
    }

    #[test]
    fn spline_on_a_circle_has_its_curvature() {
        for radius_m in [0.5, 3.0, 40.0] {
            let control = (0..=90).map(|step| {
                let angle = TAU * f64::from(step) / 120.0;
                Point::new(5.0 + radius_m * libm::cos(angle), radius_m * libm::sin(angle))
            });
            let curvature = Curvature::of([&Spline::new(3, control.collect())]);
            // The spline runs slightly inside the polygon of its control points.
            let off = curvature.max_per_m() * radius_m - 1.0;
            assert!(off.abs() < 2e-3, "{off} at {radius_m} m");
            assert_eq!(curvature.fraction_within(1.01 / radius_m), 1.0);
            assert_eq!(curvature.fraction_within(0.99 / radius_m), 0.0);
            assert_eq!(curvature.sharp_turns, 0);
        }
    }

    /// A segment of degree two is a parabola: y = x^2 here, with curvature 2 / (1 + 4 x^2)^1.5.
    #[test]
    fn quadratic_segment_has_the_curvature_of_a_parabola() {
        // Control points at the crossings of the tangents of x = -2, 0, 2, 4.
        let control = points(&[(-1.0, 0.0), (1.0, 0.0), (3.0, 8.0)]);
        let curvature_at = |x: f64| {
            let squared = 1.0 + 4.0 * x * x;
            2.0 / (squared * squared.sqrt())
        };
        let basis = Basis::new(2);
        let segment = Segment::new(&basis, &control);
        for u in [0.0, 0.3, 0.5, 1.0] {
            let place = segment.point(u);
            assert!((place.y - place.x * place.x).abs() < 1e-12, "{place}");
            assert!((segment.curvature(u) - curvature_at(place.x)).abs() < 1e-12);
        }
        let curvature = Curvature::of([&Spline::new(2, control)]);
        assert!((curvature.max_per_m() - 2.0).abs() < 1e-12);
        // Curvature decreases from x = 1 to the end at x = 2.
        let arc_m = |x: f64| {
            let s = (1.0 + 4.0 * x * x).sqrt();
            x * s / 2.0 + libm::asinh(2.0 * x) / 4.0
        };
        let expected = 1.0 - arc_m(1.0) / arc_m(2.0);
        let found = curvature.fraction_within(curvature_at(1.0) + 1e-9);
        assert!((found - expected).abs() < 0.02, "{found}, not {expected}");
    }

    #[test]
    fn corners_are_counted_without_curvature() {
        let corner = points(&[(0.0, 0.0), (4.0, 0.0), (4.0, 1.0), (8.0, 1.02), (9.0, 1.0)]);
        let sharp = Curvature::of([&Spline::polyline(&corner)]);
        // The last change of heading is below the tolerance of a chord.
        assert_eq!((sharp.sharp_turns, sharp.max_per_m()), (2, 0.0));
        assert_eq!(sharp.fraction_within(0.0), 1.0);
        // As many coincident control points as the degree make a corner; fewer leave a curve.
        let with = |count: usize| {
            let mut control = vec![Point::new(0.0, 0.0); 3];
            control.extend(vec![Point::new(4.0, 0.0); count]);
            control.extend(vec![Point::new(4.0, 4.0); 3]);
            Curvature::of([&Spline::new(3, control)])
        };
        assert_eq!((with(3).sharp_turns, with(3).max_per_m()), (1, 0.0));
        assert_eq!(with(1).sharp_turns, 0);
        assert!(with(1).max_per_m() > 0.1);
        assert!(with(1).fraction_within(0.05) < 1.0);
    }

    #[test]
    fn heading_change_between_two_splines_is_a_corner() {
        let one = Spline::polyline(&points(&[(0.0, 0.0), (4.0, 0.0)]));
        let on = Spline::polyline(&points(&[(4.0, 0.0), (9.0, 0.0)]));
        let back = Spline::polyline(&points(&[(4.0, 0.0), (0.0, 0.0)]));
        let nowhere = Spline::polyline(&points(&[(4.0, 0.0)]));
        assert_eq!(Curvature::of([&one, &on]).sharp_turns, 0);
        assert_eq!(Curvature::of([&one, &nowhere, &back]).sharp_turns, 1);
        let still = Curvature::of([&nowhere]);
        assert_eq!((still.max_per_m(), still.fraction_within(0.0)), (0.0, 1.0));
    }
}
