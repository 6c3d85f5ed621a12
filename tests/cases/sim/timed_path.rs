//! Interpolation of timed paths.

use inbye::geometry::{Point, Vector};
use inbye::sim::TimedPath;

fn path(keys: &[(f64, f64, f64)], loop_s: Option<f64>) -> TimedPath {
    let keys: Vec<_> = keys.iter().map(|&(time_s, x, y)| (time_s, Point::new(x, y))).collect();
    TimedPath::new(&keys, loop_s).expect("a valid path")
}

#[test]
fn spline_passes_keys_with_tangents_along_their_neighbours() {
    let keys = [(0.0, 0.0, 0.0), (1.0, 1.0, 2.0), (3.0, 4.0, 2.0), (4.0, 4.0, 0.0)];
    let spline = path(&keys, None).on_spline();
    for (time_s, x, y) in keys {
        assert_eq!(spline.at(time_s).0, Point::new(x, y), "{time_s}");
    }
    // Half of (4, 2), over one second before the key and two after it: the velocity is discontinuous, as in Gazebo.
    let before = spline.at(1.0 - 1e-9).1;
    let after = spline.at(1.0 + 1e-9).1;
    assert!((before - Vector::new(2.0, 1.0)).norm() < 1e-6, "{before:?}");
    assert!((after - Vector::new(1.0, 0.5)).norm() < 1e-6, "{after:?}");
    // A linear path changes its velocity there at once.
    let straight = path(&keys, None);
    assert_eq!(straight.at(0.5).1, Vector::new(1.0, 2.0));
    assert_eq!(straight.at(1.5).1, Vector::new(1.5, 0.0));
    // The midpoint is the mean of the keys plus an eighth of the difference of the tangents.
    let middle = spline.at(2.0).0;
    let bend = (Vector::new(2.0, 1.0) - Vector::new(1.5, -1.0)) / 8.0;
    assert!((middle - (Point::new(2.5, 2.0) + bend)).norm() < 1e-12);
}

#[test]
fn velocity_is_derivative_of_position() {
    let keys = [(0.5, 0.0, 0.0), (1.0, 1.0, 2.0), (3.0, 4.0, 2.0), (4.0, 0.0, 0.0)];
    for path in [path(&keys, Some(5.0)), path(&keys, Some(5.0)).on_spline()] {
        for tick in 0..240_u32 {
            let time_s = 0.013 + f64::from(tick) * 0.05;
            let slope = (path.at(time_s + 1e-6).0 - path.at(time_s - 1e-6).0) / 2e-6;
            let velocity = path.at(time_s).1;
            assert!((slope - velocity).norm() < 1e-4, "{time_s}: {slope:?} {velocity:?}");
        }
    }
}

#[test]
fn closed_spline_has_equal_velocity_at_both_ends() {
    let keys = [(0.0, 0.0, 0.0), (1.0, 2.0, 0.0), (2.0, 1.0, 2.0), (3.0, 0.0, 0.0)];
    let spline = path(&keys, Some(3.0)).on_spline();
    let (end, begin) = (spline.at(3.0 - 1e-9).1, spline.at(1e-9).1);
    assert!((end - begin).norm() < 1e-6, "{end:?} {begin:?}");
    assert!((begin - Vector::new(0.5, -1.0)).norm() < 1e-6);
}
