//! An axis of a chart: its range, its scale and its ticks.

use core::iter::successors;

use crate::report::number::{fixed, shortened};

#[derive(Clone, Copy, Debug, PartialEq)]
enum Scale {
    Linear,
    Logarithmic,
}

/// A range of values along a line. Its bounds are finite and distinct; those of a logarithmic axis are above zero.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Axis {
    low: f64,
    high: f64,
    scale: Scale,
}

/// A labelled value of an axis.
pub(crate) struct Tick {
    pub(crate) value: f64,
    pub(crate) label: String,
}

/// Approximate number of ticks of a linear axis.
const TARGET_TICKS: f64 = 6.0;

/// Least and greatest number that a logarithmic axis shows.
const SMALLEST: f64 = 1e-300;
const LARGEST: f64 = 1e300;

/// Decades above which a logarithmic axis labels only powers of ten.
const MAX_LABELLED_DECADES: f64 = 2.7;

impl Axis {
    /// A linear axis over exactly this range. The bounds may be in either order.
    pub(crate) fn exact(a: f64, b: f64) -> Self {
        let (low, high) = widened(a.min(b), a.max(b));
        Self { low, high, scale: Scale::Linear }
    }

    /// A linear axis over this range, widened to whole ticks.
    pub(crate) fn rounded(a: f64, b: f64) -> Self {
        let Self { low, high, scale } = Self::exact(a, b);
        let step = round_step((high - low) / TARGET_TICKS);
        Self {
            low: libm::floor(low / step + 1e-9) * step,
            high: libm::ceil(high / step - 1e-9) * step,
            scale,
        }
    }

    /// A logarithmic axis over a range above zero, widened to 1, 2 or 5 times a power of ten.
    pub(crate) fn logarithmic(low: f64, high: f64) -> Self {
        // Beyond these powers of ten there is no next round number.
        let [low, high] = [low, high].map(|end| end.clamp(SMALLEST, LARGEST));
        let low = round_number_below(low * (1.0 + 1e-9));
        let mut bound = low;
        while bound < high * (1.0 - 1e-9) || bound <= low {
            bound = round_number_above(bound);
        }
        Self { low, high: bound, scale: Scale::Logarithmic }
    }

    /// The position of a value: 0 at the low end, 1 at the high end, outside 0..1 for values outside the range.
    pub(crate) fn fraction(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear => (value - self.low) / (self.high - self.low),
            Scale::Logarithmic => libm::log(value / self.low) / libm::log(self.high / self.low),
        }
    }

    /// The value at a position, the inverse of [`Axis::fraction`].
    pub(crate) fn value_at(&self, fraction: f64) -> f64 {
        match self.scale {
            Scale::Linear => self.low + fraction * (self.high - self.low),
            Scale::Logarithmic => self.low * libm::pow(self.high / self.low, fraction),
        }
    }

    /// The ticks within the range, in ascending order.
    pub(crate) fn ticks(&self) -> Vec<Tick> {
        let Self { low, high, scale } = *self;
        if scale == Scale::Linear {
            let step = round_step((high - low) / TARGET_TICKS);
            let decimals = libm::ceil(-libm::log10(step) - 1e-9).max(0.0) as usize;
            let first = libm::ceil(low / step - 1e-9) as i64;
            let last = libm::floor(high / step + 1e-9) as i64;
            let values = (first..=last).map(|multiple| multiple as f64 * step);
            return values.map(|value| Tick { value, label: fixed(value, decimals) }).collect();
        }
        let only_tens = libm::log10(high / low) > MAX_LABELLED_DECADES;
        let is_labelled = |value: &f64| {
            let exponent = libm::log10(*value);
            !only_tens || (exponent - libm::round(exponent)).abs() < 1e-6
        };
        successors(Some(low), |value| Some(round_number_above(*value)))
            .take_while(|value| *value <= high * (1.0 + 1e-9))
            .filter(is_labelled)
            .map(|value| Tick { value, label: shortened(value) })
            .collect()
    }
}

/// Widens a range that is (almost) a single value.
fn widened(low: f64, high: f64) -> (f64, f64) {
    let least = (low.abs().max(high.abs()) * 1e-6).max(1e-9);
    if high - low >= least {
        return (low, high);
    }
    let margin = (low.abs() * 0.1).max(0.1);
    (low - margin, high + margin)
}

/// The least step that is not below a given one and is 1, 2 or 5 times a power of ten.
fn round_step(step: f64) -> f64 {
    let below = round_number_below(step);
    if below * (1.0 + 1e-9) >= step { below } else { round_number_above(below) }
}

/// The greatest number that is not above a positive value and is 1, 2 or 5 times a power of ten.
pub(crate) fn round_number_below(value: f64) -> f64 {
    let power = libm::exp10(libm::floor(libm::log10(value)));
    let numbers = [5.0 * power, 2.0 * power];
    numbers.into_iter().find(|&number| number <= value).unwrap_or(power)
}

/// The next greater number that is 1, 2 or 5 times a power of ten.
fn round_number_above(number: f64) -> f64 {
    let exponent = libm::floor(libm::log10(number) + 1e-9);
    let power = libm::exp10(exponent);
    match libm::round(number / power) as i64 {
        1 => 2.0 * power,
        2 => 5.0 * power,
        _ => libm::exp10(exponent + 1.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logarithmic_axis_ends_for_all_numbers_above_zero() {
        for (low, high) in [(5e-324, 1.0), (1.0, f64::MAX), (1e-310, 1e308)] {
            let axis = Axis::logarithmic(low, high);
            assert!(!axis.ticks().is_empty(), "{low} to {high}");
        }
    }

    fn labels(axis: &Axis) -> Vec<String> {
        axis.ticks().into_iter().map(|tick| tick.label).collect()
    }

    #[test]
    fn linear_axis_has_round_ticks_with_equal_decimals() {
        let axis = Axis::rounded(0.0, 0.97);
        assert_eq!(labels(&axis), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(labels(&Axis::exact(0.0, 47.0)), ["0", "10", "20", "30", "40"]);
        assert_eq!(labels(&Axis::rounded(-0.3, 0.4)), ["-0.4", "-0.2", "0.0", "0.2", "0.4"]);
    }

    #[test]
    fn logarithmic_axis_has_ticks_at_1_2_5_or_at_decades() {
        assert_eq!(labels(&Axis::logarithmic(0.3, 4.0)), ["0.2", "0.5", "1", "2", "5"]);
        assert_eq!(labels(&Axis::logarithmic(1.0, 1e4)), ["1", "10", "100", "1k", "10k"]);
    }

    #[test]
    fn axis_of_a_single_value_has_a_range_and_ticks() {
        for axis in [Axis::rounded(0.0, 0.0), Axis::exact(7.0, 7.0), Axis::logarithmic(2.0, 2.0)] {
            assert!(axis.low < axis.high && !axis.ticks().is_empty(), "{axis:?}");
        }
    }

    #[test]
    fn logarithmic_axis_maps_equal_ratios_to_equal_lengths() {
        let axis = Axis::logarithmic(0.01, 100.0);
        for (value, fraction) in [(0.01, 0.0), (0.1, 0.25), (1.0, 0.5), (100.0, 1.0)] {
            assert!((axis.fraction(value) - fraction).abs() < 1e-12, "{value}");
            assert!((axis.value_at(fraction) / value - 1.0).abs() < 1e-12, "{value}");
        }
    }
}
