//! The dynamic window: the velocities that the robot may have and can reach (paper, eqs. 28, 29 and 31).

use super::Sampling;
use crate::geometry::Twist;
use crate::robot::{Limits, TickTime};

/// Equally spaced values from `low` to `high`, both included; a few are replaced. A single value is `low`.
///
/// An axis with at least four values has every value of `through` that lies between its ends: it replaces the nearest of the
/// spaced values between the ends. Where both have the same nearest value, the second one replaces its neighbour. With three
/// values only the first one finds a place. The values stay in order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    /// The first value.
    pub low: f64,
    /// The last value, at least `low`.
    pub high: f64,
    /// Number of values, at least one.
    pub count: u32,
    /// Values that the axis has if they lie between its ends; others have no effect.
    pub through: [Option<f64>; 2],
}

impl Axis {
    /// Equally spaced values.
    #[must_use]
    pub const fn new(low: f64, high: f64, count: u32) -> Self {
        Self { low, high, count, through: [None; 2] }
    }

    /// The value at an index.
    #[must_use]
    pub fn value(&self, index: u32) -> f64 {
        AxisValues::new(*self).at(index)
    }

    /// Returns `low + index (high - low) / (count - 1)`, at most `high`: rounding can lift the formula above it.
    #[inline]
    pub(super) fn spaced(&self, index: u32) -> f64 {
        if self.count == 1 {
            return self.low;
        }
        let above_low = f64::from(index) * (self.high - self.low) / f64::from(self.count - 1);
        (self.low + above_low).min(self.high)
    }

    /// The values that replace spaced ones, with their indices.
    #[inline]
    pub(super) fn replaced(&self) -> [Option<(u32, f64)>; 2] {
        // The index of the last value before the end.
        let last = self.count.saturating_sub(2);
        let place = |value: Option<f64>| {
            let value =
                value.filter(|value| last > 0 && self.low < *value && *value < self.high)?;
            let share = (value - self.low) / (self.high - self.low);
            let nearest = (share * f64::from(self.count - 1)).round() as u32;
            Some((nearest.clamp(1, last), value))
        };
        let places = self.through.map(place);
        let [Some((at, first)), Some((other, second))] = places else {
            return places;
        };
        if at != other || first == second {
            return places;
        }
        let is_above = second > first;
        match (is_above, at > 1, at < last) {
            (true, _, true) => [Some((at, first)), Some((at + 1, second))],
            (false, true, _) => [Some((at, first)), Some((at - 1, second))],
            (true, true, false) => [Some((at - 1, first)), Some((at, second))],
            (false, false, true) => [Some((at + 1, first)), Some((at, second))],
            (_, false, false) => [Some((at, first)), None],
        }
    }

    /// The largest absolute value.
    #[must_use]
    pub fn max_abs(&self) -> f64 {
        self.low.abs().max(self.high.abs())
    }
}

/// The values of an axis, for many look-ups.
#[derive(Clone, Copy, Debug)]
pub(super) struct AxisValues {
    pub axis: Axis,
    replaced: [Option<(u32, f64)>; 2],
}

impl AxisValues {
    pub fn new(axis: Axis) -> Self {
        Self { replaced: axis.replaced(), axis }
    }

    /// The value at an index.
    #[inline(always)]
    pub fn at(&self, index: u32) -> f64 {
        for (at, value) in self.replaced.into_iter().flatten() {
            if at == index {
                return value;
            }
        }
        self.axis.spaced(index)
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
    /// The window around the current twist: within the limits (eq. 28) and within reach in one control period, seconds, or at a
    /// tick of a control loop (eq. 29). The further braking of a late tick ends at zero.
    ///
    /// Standing still and driving straight ahead are among the samples where they are within the window.
    ///
    /// A current speed outside the limits, by noise or after a limit was lowered, gives the part of the limits that is
    /// nearest to the reachable velocities. The window is never empty.
    #[must_use]
    pub fn new(
        limits: &Limits,
        current: &Twist,
        time: impl Into<TickTime>,
        sampling: Sampling,
    ) -> Self {
        let time = time.into();
        let (gain_s, braking_s) = (time.accelerating_s(), time.braking_s());
        let axis = |now: f64, (brake, gain): (f64, f64), (min, max): (f64, f64), count| {
            let (mut low, mut high) = (now + brake * gain_s, now + gain * gain_s);
            if now >= 0.0 {
                low = low.min((now + brake * braking_s).max(0.0));
            } else {
                high = high.max((now + gain * braking_s).min(0.0));
            }
            let (low, high) = (low.clamp(min, max), high.clamp(min, max));
            Axis { low, high, count, through: [Some(0.0), None] }
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

    /// The window with these velocities among its samples, where they are within it.
    #[must_use]
    pub const fn through(mut self, twist: &Twist) -> Self {
        self.vx.through[1] = Some(twist.linear);
        self.vtheta.through[1] = Some(twist.angular);
        self
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
