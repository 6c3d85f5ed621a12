//! Tilt of a base by its accelerometer and gyro.

use super::Tilt;
use crate::geometry::wrap_angle;

/// Time constant between gyro and accelerometer, seconds: longer than a base accelerates at its limit, and short against the
/// drift of a gyro.
const TRUST_S: f64 = 0.5;

/// Longest time over which rates are integrated, seconds. After a longer gap the accelerometer decides alone.
const MAX_STEP_S: f64 = 0.5;

/// Smallest magnitude of a measured acceleration, m/s^2: half of gravity. A controller without an accelerometer reports zeros.
const MIN_ACCELERATION: f64 = 4.9;

/// A complementary filter: the gyro shows fast changes, and the accelerometer the direction of gravity.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct TiltFilter {
    /// Time of the last update, seconds, and the tilt.
    last: Option<(f64, Tilt)>,
}

impl TiltFilter {
    /// Takes an acceleration with that of gravity, m/s^2, and turn rates, rad/s, about x, y and z. Returns the tilt; none
    /// without an accelerometer.
    pub(super) fn update(
        &mut self,
        acceleration: [f64; 3],
        gyro: [f64; 3],
        now_s: f64,
    ) -> Option<Tilt> {
        let [x, y, z] = acceleration;
        let across = libm::hypot(y, z);
        if !libm::hypot(x, across).is_finite() || libm::hypot(x, across) < MIN_ACCELERATION {
            self.last = None;
            return None;
        }
        let by_gravity = Tilt { roll: libm::atan2(y, z), pitch: libm::atan2(-x, across) };
        let tilt = match self.last {
            Some((last_s, last)) if (0.0..=MAX_STEP_S).contains(&(now_s - last_s)) => {
                let time_s = now_s - last_s;
                let share = time_s / (TRUST_S + time_s);
                let blend = |last: f64, rate: f64, by_gravity: f64| {
                    let turned = last + rate * time_s;
                    wrap_angle(turned + share * wrap_angle(by_gravity - turned))
                };
                Tilt {
                    roll: blend(last.roll, gyro[0], by_gravity.roll),
                    pitch: blend(last.pitch, gyro[1], by_gravity.pitch),
                }
            }
            _ => by_gravity,
        };
        self.last = Some((now_s, tilt));
        Some(tilt)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tilt_follows_gravity_with_the_signs_of_rep_103() {
        let still = |acceleration| TiltFilter::default().update(acceleration, [0.0; 3], 0.0);
        assert_eq!(still([0.0, 0.0, 9.8]), Some(Tilt::default()));
        let front_down = still([-4.9, 0.0, 8.49]).expect("a tilt");
        assert!((front_down.pitch - 0.524).abs() < 1e-3, "{front_down:?}");
        let left_up = still([0.0, 4.9, 8.49]).expect("a tilt");
        assert!((left_up.roll - 0.524).abs() < 1e-3, "{left_up:?}");
        assert_eq!(still([0.0; 3]), None, "no accelerometer");
        assert_eq!(still([f64::NAN, 0.0, 9.8]), None);
    }

    /// Braking at 1.5 m/s^2 for 0.6 s looks like a pitch of 0.15 rad to the accelerometer.
    #[test]
    fn braking_shows_little_tilt_and_a_tipping_base_shows_it_at_once() {
        let mut filter = TiltFilter::default();
        let mut now_s = 0.0;
        let mut run = |acceleration, gyro, steps| {
            let mut tilt = None;
            for _ in 0..steps {
                now_s += 0.05;
                tilt = filter.update(acceleration, gyro, now_s);
            }
            tilt.expect("a tilt")
        };
        run([0.0, 0.0, 9.8], [0.0; 3], 20);
        let braking = run([-1.5, 0.0, 9.8], [0.0; 3], 12);
        assert!(braking.pitch < 0.12, "{braking:?}");
        run([0.0, 0.0, 9.8], [0.0; 3], 60);
        let tipped = run([0.0, 0.0, 9.8], [0.0, 2.0, 0.0], 4);
        assert!(tipped.pitch > 0.25, "{tipped:?}");
    }

    /// The tilt after an update at a time, from a level base at the time zero.
    fn after(acceleration: [f64; 3], gyro: [f64; 3], now_s: f64) -> Tilt {
        let mut filter = TiltFilter::default();
        filter.update([0.0, 0.0, 9.8], [0.0; 3], 0.0);
        filter.update(acceleration, gyro, now_s).expect("a tilt")
    }

    #[test]
    fn each_gyro_axis_turns_its_own_angle() {
        let level = [0.0, 0.0, 9.8];
        // 1 rad/s for 0.1 s; the accelerometer takes back a sixth.
        let rolled = after(level, [1.0, 0.0, 0.0], 0.1);
        assert!((rolled.roll - 0.1 * 5.0 / 6.0).abs() < 1e-12 && rolled.pitch == 0.0, "{rolled:?}");
        let pitched = after(level, [0.0, -1.0, 0.0], 0.1);
        assert!((pitched.pitch + 0.1 * 5.0 / 6.0).abs() < 1e-12 && pitched.roll == 0.0);
    }

    /// A base on its back whose roll is measured as just below pi, then as just above minus pi.
    #[test]
    fn tilt_of_a_base_on_its_back_does_not_swing_through_level() {
        let on_its_back = |y: f64| [0.0, y, -9.8];
        let mut filter = TiltFilter::default();
        for (cycle, y) in [0.1, -0.1, 0.1, -0.1].into_iter().enumerate() {
            let now_s = 0.1 * cycle as f64;
            let tilt = filter.update(on_its_back(y), [0.0; 3], now_s).expect("a tilt");
            assert!(tilt.roll.abs() > 3.1, "{now_s} s: {tilt:?}");
        }
        // A roll by the gyro beyond pi goes on from minus pi.
        let rolled = filter.update(on_its_back(0.0), [4.0, 0.0, 0.0], 0.4).expect("a tilt");
        assert!((-3.0..-2.6).contains(&rolled.roll), "{rolled:?}");
    }

    #[test]
    fn accelerometer_decides_alone_after_a_gap_and_a_backward_clock() {
        // Nose down by 30 degrees.
        let down = [-4.9, 0.0, 8.49];
        let steps = [(0.49, false), (0.51, true), (-0.1, true)];
        for (now_s, is_gap) in steps {
            let tilt = after(down, [0.0; 3], now_s);
            assert_eq!((tilt.pitch - 0.524).abs() < 1e-3, is_gap, "{now_s} s: {tilt:?}");
        }
        // A report without gravity forgets the tilt before it.
        let mut filter = TiltFilter::default();
        filter.update([0.0, 0.0, 9.8], [0.0; 3], 0.0);
        assert_eq!(filter.update([0.0; 3], [0.0; 3], 0.1), None);
        let tilt = filter.update(down, [0.0; 3], 0.2).expect("a tilt");
        assert!((tilt.pitch - 0.524).abs() < 1e-3, "{tilt:?}");
    }

    #[test]
    fn acceleration_below_half_of_gravity_is_no_measurement() {
        let of = |z| TiltFilter::default().update([0.0, 0.0, z], [0.0; 3], 0.0);
        assert_eq!((of(4.8), of(5.0)), (None, Some(Tilt::default())));
        assert_eq!(TiltFilter::default().update([f64::INFINITY, 0.0, 9.8], [0.0; 3], 0.0), None);
    }
}
