//! Curvature and corners of splines.

use core::f64::consts::TAU;

use inbye::geometry::Point;
use inbye::global::{Curvature, Spline};

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
fn quadratic_spline_has_the_curvature_of_a_parabola() {
    // Control points at the crossings of the tangents of x = -2, 0, 2, 4.
    let control = points(&[(-1.0, 0.0), (1.0, 0.0), (3.0, 8.0)]);
    let curvature_at = |x: f64| {
        let squared = 1.0 + 4.0 * x * x;
        2.0 / (squared * squared.sqrt())
    };
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
