//! The dynamic window: the velocities that the robot may have and can reach (paper, eqs. 28, 29 and 31).

use crate::geometry::Twist;
use crate::robot::Limits;

/// Equally spaced values from `low` to `high`, both included; one value is `low` itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    /// The first value.
    pub low: f64,
    /// The last value, at least `low`.
    pub high: f64,
    /// How many values, at least one.
    pub count: u32,
}

impl Axis {
    /// Value number `index`: `low + index (high - low) / (count - 1)`, which rounding does not lift above `high`.
    #[must_use]
    #[inline]
    pub fn value(&self, index: u32) -> f64 {
        if self.count == 1 {
            return self.low;
        }
        let above_low = f64::from(index) * (self.high - self.low) / f64::from(self.count - 1);
        (self.low + above_low).min(self.high)
    }

    /// The value of greatest size.
    #[must_use]
    pub fn largest(&self) -> f64 {
        self.low.abs().max(self.high.abs())
    }
}

/// The rectangle V1 x V2 of samples; V3, the braking constraint, is checked for each sample on its own.
///
/// Sample `index` has the forward speed number `index % linear.count` and the turn rate `index / linear.count`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Forward speeds, m/s.
    pub linear: Axis,
    /// Turn rates, rad/s.
    pub angular: Axis,
}

impl Window {
    /// The window around the current twist: what the limits allow at all (eq. 28) and within one control period in
    /// seconds (eq. 29). A current speed outside the limits, by noise or by a limit just lowered, gives the part of
    /// the limits nearest to what can be reached, never an empty window.
    #[must_use]
    pub fn new(
        limits: &Limits,
        current: &Twist,
        control_period_s: f64,
        vx_samples: u32,
        vtheta_samples: u32,
    ) -> Self {
        let axis = |now: f64, brake: f64, gain: f64, (least, most): (f64, f64), count| Axis {
            low: (now + brake * control_period_s).clamp(least, most),
            high: (now + gain * control_period_s).clamp(least, most),
            count,
        };
        let forward = (limits.min_vel_x, limits.max_vel_x);
        let turn = (-limits.max_vel_theta, limits.max_vel_theta);
        Self {
            linear: axis(
                current.linear,
                limits.decel_lim_x,
                limits.acc_lim_x,
                forward,
                vx_samples,
            ),
            angular: axis(
                current.angular,
                limits.decel_lim_theta,
                limits.acc_lim_theta,
                turn,
                vtheta_samples,
            ),
        }
    }

    /// Number of samples.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.linear.count as usize * self.angular.count as usize
    }

    /// Whether there is no sample. Never true of a window made by [`Window::new`] with counts above zero.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The velocity of a sample.
    #[must_use]
    pub fn twist(&self, index: u32) -> Twist {
        Twist {
            linear: self.linear.value(index % self.linear.count),
            angular: self.angular.value(index / self.linear.count),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_window_is_what_limits_and_accelerations_allow_together() {
        let limits = Limits {
            acc_lim_x: 0.5,
            decel_lim_x: -1.0,
            acc_lim_theta: 1.0,
            decel_lim_theta: -1.0,
            ..Limits::default()
        };
        let window = Window::new(&limits, &Twist::new(0.98, 0.0), 0.1, 5, 3);
        // 0.98 - 1.0 * 0.1 = 0.88; 0.98 + 0.5 * 0.1 = 1.03, cut at 1.0.
        assert!((window.linear.low - 0.88).abs() < 1e-12 && window.linear.high == 1.0);
        assert!((window.angular.low + 0.1).abs() < 1e-12);
        let middle = window.twist(7);
        assert!((middle.linear - 0.94).abs() < 1e-12 && middle.angular.abs() < 1e-12);
    }

    #[test]
    fn rounding_lifts_no_value_above_the_highest() {
        let (low, high, count) = (0.0, 0.4, 4);
        assert!(low + 3.0 * (high - low) / 3.0 > high, "it would here");
        assert_eq!(Axis { low, high, count }.value(3), high);
    }
}
