//! The dynamic window and its samples.

use inbye::geometry::Twist;
use inbye::local::internals::evenly_spaced;
use inbye::local::{Axis, Sampling, Window};
use inbye::robot::{Limits, TickTime};
use proptest::prelude::*;

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
fn window_of_a_late_tick_is_wider_only_towards_standstill() {
    let limits = Limits::default().min_vel_x(-0.5).acc_lim_x(0.5);
    let sampling = Sampling { vx_samples: 5, vtheta_samples: 3 };
    let late = TickTime::between(Some(1.0), 1.4, 0.1);
    for (twist, low, high) in
        [(0.8, 0.4, 0.85), (0.3, 0.0, 0.35), (0.05, -0.05, 0.1), (-0.4, -0.5, -0.2)]
    {
        let now = Twist::new(twist, twist);
        let window = Window::new(&limits, &now, late, sampling);
        let vx = window.vx;
        assert!((vx.low - low).abs() < 1e-9 && (vx.high - high).abs() < 1e-9, "{twist}: {vx:?}");
        let punctual = Window::new(&limits, &now, 0.1, sampling);
        assert!(window.vtheta.low <= punctual.vtheta.low, "{twist}");
        assert!(window.vtheta.high >= punctual.vtheta.high, "{twist}");
    }
}

#[test]
fn axis_value_never_exceeds_high() {
    let (low, high, count) = (0.0, 0.4, 4);
    assert!(low + 3.0 * (high - low) / 3.0 > high, "the plain formula exceeds `high` here");
    assert_eq!(Axis::new(low, high, count).value(3), high);
}

/// An even number of turn rates, spaced equally over a symmetric window, has no zero.
#[test]
fn samples_include_straight_ahead_standing_still_and_the_last_command() {
    let sampling = Sampling { vx_samples: 20, vtheta_samples: 40 };
    let limits = Limits::default().min_vel_x(-0.3);
    let last_command = Twist::new(0.031, -0.017);
    let window = Window::new(&limits, &Twist::STOP, 0.1, sampling).through(&last_command);
    let twists: Vec<Twist> = (0..window.len() as u32).map(|index| window.twist(index)).collect();
    let last_linear = Twist::new(last_command.linear, 0.0);
    for wanted in [Twist::STOP, last_command, last_linear] {
        assert!(twists.contains(&wanted), "{wanted:?} is no sample");
    }
    // Away from standstill the window has no standing still, and driving straight ahead remains.
    let window = Window::new(&limits, &Twist::new(0.5, 0.1), 0.1, sampling);
    let rates = values(&window.vtheta);
    assert!(rates.contains(&0.0) && !values(&window.vx).contains(&0.0));
    // A window of turns to one side has no zero.
    let window = Window::new(&limits, &Twist::new(0.5, 0.9), 0.1, sampling);
    assert_eq!(values(&window.vtheta), values(&Axis { through: [None; 2], ..window.vtheta }));
}

fn values(axis: &Axis) -> Vec<f64> {
    (0..axis.count).map(|index| axis.value(index)).collect()
}

proptest! {
    #[test]
    fn axis_keeps_its_ends_its_order_and_its_wanted_values(
        low in -2.0..2.0_f64,
        width in 0.0..3.0_f64,
        count in 1..60_u32,
        places in prop::array::uniform2(-0.5..1.5_f64),
    ) {
        let spaced = Axis::new(low, low + width, count);
        let through = places.map(|place| Some(low + place * width));
        let axis = Axis { through, ..spaced };
        let (values, spaced) = (values(&axis), values(&spaced));
        prop_assert!(values.is_sorted(), "{values:?}");
        prop_assert_eq!((values[0], values.last()), (spaced[0], spaced.last()));
        let changed = values.iter().zip(&spaced).filter(|(one, other)| one != other).count();
        prop_assert!(changed <= 2);
        let least_step = width / f64::from(count);
        for (value, other) in values.iter().zip(&spaced) {
            prop_assert!((value - other).abs() <= 3.0 * least_step + 1e-12);
        }
        let is_inside = |value: &f64| low < *value && *value < low + width;
        for value in through.iter().flatten().filter(|value| count >= 4 && is_inside(value)) {
            prop_assert!(values.contains(value), "{value} is not in {values:?}");
        }
    }
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
