//! The dynamic window: the velocities that the robot may have and can reach (paper, eqs. 28, 29 and 31).

use super::Sampling;
use crate::geometry::Twist;
use crate::robot::Limits;

/// Equally spaced values from `low` to `high`, both included. A single value is `low`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    /// The first value.
    pub low: f64,
    /// The last value, at least `low`.
    pub high: f64,
    /// Number of values, at least one.
    pub count: u32,
}

impl Axis {
    /// Returns `low + index (high - low) / (count - 1)`, at most `high`: rounding can lift the formula above it.
    #[must_use]
    #[inline]
    pub fn value(&self, index: u32) -> f64 {
        if self.count == 1 {
            return self.low;
        }
        let above_low = f64::from(index) * (self.high - self.low) / f64::from(self.count - 1);
        (self.low + above_low).min(self.high)
    }

    /// The largest absolute value.
    #[must_use]
    pub fn max_abs(&self) -> f64 {
        self.low.abs().max(self.high.abs())
    }
}

/// The rectangle V1 x V2 of samples. V3, the braking constraint, is checked for each sample.
///
/// Sample `index` has the forward speed `index % vx.count` and the turn rate `index / vx.count`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Forward speeds, m/s.
    pub vx: Axis,
    /// Turn rates, rad/s.
    pub vtheta: Axis,
}

impl Window {
    /// The window around the current twist: within the limits (eq. 28) and within reach in one control period, seconds
    /// (eq. 29).
    ///
    /// A current speed outside the limits, by noise or after a limit was lowered, gives the part of the limits that is
    /// nearest to the reachable velocities. The window is never empty.
    #[must_use]
    pub fn new(
        limits: &Limits,
        current: &Twist,
        control_period_s: f64,
        sampling: Sampling,
    ) -> Self {
        let axis = |now: f64, (brake, gain): (f64, f64), (min, max): (f64, f64), count| Axis {
            low: (now + brake * control_period_s).clamp(min, max),
            high: (now + gain * control_period_s).clamp(min, max),
            count,
        };
        let Sampling { vx_samples, vtheta_samples } = sampling;
        let (vx_rates, vtheta_rates) = (
            (limits.decel_lim_x, limits.acc_lim_x),
            (limits.decel_lim_theta, limits.acc_lim_theta),
        );
        let vx_range = (limits.min_vel_x, limits.max_vel_x);
        let vtheta_range = (-limits.max_vel_theta, limits.max_vel_theta);
        Self {
            vx: axis(current.linear, vx_rates, vx_range, vx_samples),
            vtheta: axis(current.angular, vtheta_rates, vtheta_range, vtheta_samples),
        }
    }

    /// Number of samples.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.vx.count as usize * self.vtheta.count as usize
    }

    /// Whether there is no sample. Always false for a window from [`Window::new`] with counts above zero.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The velocity of a sample.
    #[must_use]
    pub fn twist(&self, index: u32) -> Twist {
        Twist {
            linear: self.vx.value(index % self.vx.count),
            angular: self.vtheta.value(index / self.vx.count),
        }
    }
}
