//! The dynamic window and its samples.

use inbye::geometry::Twist;
use inbye::local::internals::evenly_spaced;
use inbye::local::{Axis, Sampling, Window};
use inbye::robot::Limits;

#[test]
fn window_intersects_limits_and_reachable_velocities() {
    let limits =
        Limits::default().acc_lim_x(0.5).decel_lim_x(-1.0).acc_lim_theta(1.0).decel_lim_theta(-1.0);
    let sampling = Sampling { vx_samples: 5, vtheta_samples: 3 };
    let window = Window::new(&limits, &Twist::new(0.98, 0.0), 0.1, sampling);
    // 0.98 - 1.0 * 0.1 = 0.88; 0.98 + 0.5 * 0.1 = 1.03, cut at 1.0.
    assert!((window.vx.low - 0.88).abs() < 1e-12 && window.vx.high == 1.0);
    assert!((window.vtheta.low + 0.1).abs() < 1e-12);
    let middle = window.twist(7);
    assert!((middle.linear - 0.94).abs() < 1e-12 && middle.angular.abs() < 1e-12);
}

#[test]
fn axis_value_never_exceeds_high() {
    let (low, high, count) = (0.0, 0.4, 4);
    assert!(low + 3.0 * (high - low) / 3.0 > high, "the plain formula exceeds `high` here");
    assert_eq!(Axis { low, high, count }.value(3), high);
}

#[test]
fn evenly_spaced_indices_include_both_ends() {
    let indices = |count, max| evenly_spaced(count, max).collect::<Vec<_>>();
    assert_eq!(indices(10, 4), [0, 3, 6, 9]);
    assert_eq!(indices(3, 9), [0, 1, 2]);
    assert_eq!(indices(7, 1), [0]);
    assert_eq!(indices(1, 5), [0]);
    assert!(indices(5, 0).is_empty());
}
