//! Integer sine, cosine and direction within their documented bounds.

use core::f64::consts::TAU;

use inbye::numeric::{HALF_TURN, ONE_Q20, QUARTER_TURN, atan2_turn, cos_q20, sin_q20};

const TURN: f64 = 4_294_967_296.0;

#[test]
fn sine_and_cosine_stay_within_their_bound() {
    for step in 0..=200_000_u32 {
        let angle = step.wrapping_mul(21_475);
        let radians = f64::from(angle) / TURN * TAU;
        let sine = f64::from(sin_q20(angle)) / f64::from(ONE_Q20);
        let cosine = f64::from(cos_q20(angle)) / f64::from(ONE_Q20);
        assert!((sine - libm::sin(radians)).abs() < 6e-7, "sin {radians}");
        assert!((cosine - libm::cos(radians)).abs() < 6e-7, "cos {radians}");
    }
    for (quarter, expected) in [(0, 0), (1, ONE_Q20), (2, 0), (3, -ONE_Q20)] {
        assert_eq!(sin_q20(QUARTER_TURN.wrapping_mul(quarter)), expected);
    }
}

#[test]
fn direction_stays_within_its_bound_in_every_octant_and_size() {
    for size in [3.0, 500.0, 4e4, 8e6, 1e9] {
        for step in 0..20_000 {
            let radians = f64::from(step) / 20_000.0 * TAU;
            let (x, y) = (libm::cos(radians) * size, libm::sin(radians) * size);
            let (x, y) = (x.round() as i32, y.round() as i32);
            let expected = libm::atan2(f64::from(y), f64::from(x)) / TAU * TURN;
            let error = atan2_turn(y, x).wrapping_sub(expected.round() as i64 as u32) as i32;
            let radians_off = f64::from(error) / TURN * TAU;
            assert!(radians_off.abs() < 3e-5, "({x}, {y}): {radians_off}");
        }
    }
    assert_eq!(atan2_turn(0, 0), 0);
    assert_eq!(atan2_turn(0, -5), HALF_TURN);
}
