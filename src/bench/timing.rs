//! Statistics of times: percentiles, from a histogram of fixed size or from all values, and missed deadlines.

use hdrhistogram::Histogram;
use serde::Serialize;

use super::BenchError;

const NANOSECONDS_PER_SECOND: f64 = 1e9;
const NANOSECONDS_PER_MILLISECOND: f64 = 1e6;

/// One hour: no decision takes longer.
const LONGEST_NANOSECONDS: u64 = 3_600_000_000_000;

/// Significant decimal digits that the histogram keeps of each time.
const DIGITS: u8 = 3;

/// Recorded times, each to 0.1 %. Memory does not grow with their number.
#[derive(Clone, Debug)]
pub struct Latencies {
    nanoseconds: Histogram<u64>,
}

/// Percentiles of recorded times, milliseconds, each within 0.1 %. In JSON the fields are `count`, `p50`, `p95`,
/// `p99` and `max`; the name of the object has the unit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct LatencySummary {
    /// Times recorded.
    pub count: u64,
    /// Median.
    #[serde(rename = "p50")]
    pub p50_ms: f64,
    /// 95th percentile.
    #[serde(rename = "p95")]
    pub p95_ms: f64,
    /// 99th percentile.
    #[serde(rename = "p99")]
    pub p99_ms: f64,
    /// Slowest.
    #[serde(rename = "max")]
    pub max_ms: f64,
}

impl Default for Latencies {
    fn default() -> Self {
        Self {
            nanoseconds: Histogram::new_with_max(LONGEST_NANOSECONDS, DIGITS)
                .expect("three digits and a bound above two are within the ranges allowed"),
        }
    }
}

impl Latencies {
    /// Adds one time in seconds. It is kept in whole nanoseconds; a time above an hour counts as an hour.
    ///
    /// # Errors
    /// Fails when the time is not finite or below zero; it is then not counted.
    pub fn record(&mut self, seconds: f64) -> Result<(), BenchError> {
        if !(seconds.is_finite() && seconds >= 0.0) {
            return Err(BenchError::NotATime { seconds });
        }
        self.nanoseconds.saturating_record((seconds * NANOSECONDS_PER_SECOND).round() as u64);
        Ok(())
    }

    /// Adds all times of another record.
    pub fn merge(&mut self, other: &Self) {
        for bucket in other.nanoseconds.iter_recorded() {
            self.nanoseconds
                .saturating_record_n(bucket.value_iterated_to(), bucket.count_at_value());
        }
    }

    /// Number of times recorded.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.nanoseconds.len()
    }

    /// The smallest time that at least this share of the recorded times, 0..=1, does not exceed, in milliseconds;
    /// none before the first recording.
    #[must_use]
    pub fn quantile_ms(&self, share: f64) -> Option<f64> {
        (self.count() > 0)
            .then(|| self.nanoseconds.value_at_quantile(share) as f64 / NANOSECONDS_PER_MILLISECOND)
    }

    /// The usual percentiles; none before the first recording.
    #[must_use]
    pub fn summary(&self) -> Option<LatencySummary> {
        Some(LatencySummary {
            count: self.count(),
            p50_ms: self.quantile_ms(0.50)?,
            p95_ms: self.quantile_ms(0.95)?,
            p99_ms: self.quantile_ms(0.99)?,
            max_ms: self.quantile_ms(1.0)?,
        })
    }
}

/// The value that this share of the values, 0..=1, does not exceed: the smallest one at 0, the median at 0.5, the greatest one at 1, and
/// between two values on the straight line from one to the other, as in numpy and pandas. None of no values.
#[must_use]
pub fn percentile(values: Vec<f64>, share: f64) -> Option<f64> {
    let [value] = percentiles(values, [share]);
    value
}

/// The [`percentile`] of each share.
#[must_use]
pub fn percentiles<const N: usize>(mut values: Vec<f64>, shares: [f64; N]) -> [Option<f64>; N] {
    values.sort_by(f64::total_cmp);
    shares.map(|share| {
        let place = share * values.len().checked_sub(1)? as f64;
        let (below, above) = (libm::floor(place), libm::ceil(place));
        let (low, high) = (*values.get(below as usize)?, *values.get(above as usize)?);
        // Infinite values may be equal.
        Some(if low == high { low } else { low + (place - below) * (high - low) })
    })
}

/// Quantile of the normal distribution for a confidence of 95 %.
const Z_95: f64 = 1.959_963_984_540_054;

/// The interval of 95 % confidence of a probability, from the number of successes among trials (Wilson, "Probable
/// inference, the law of succession, and statistical inference", 1927); from zero to one without trials.
#[must_use]
pub fn wilson_interval(successes: usize, trials: usize) -> [f64; 2] {
    if trials == 0 {
        return [0.0, 1.0];
    }
    let (n, z) = (trials as f64, Z_95);
    let share = (successes as f64 / n).min(1.0);
    let center = (share + z * z / (2.0 * n)) / (1.0 + z * z / n);
    let half = z / (1.0 + z * z / n) * (share * (1.0 - share) / n + z * z / (4.0 * n * n)).sqrt();
    // Rounding leaves a little beyond the ends.
    let low = if successes == 0 { 0.0 } else { (center - half).max(0.0) };
    let high = if successes >= trials { 1.0 } else { (center + half).min(1.0) };
    [low, high]
}

/// Rates of common control loops, Hz.
pub const RATES_HZ: [f64; 3] = [20.0, 50.0, 100.0];

/// Number of late decisions for each of [`RATES_HZ`], counted from the exact times, not from percentiles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Misses([usize; RATES_HZ.len()]);

impl Misses {
    /// Adds a decision with its time in seconds. A decision that takes the whole period is in time.
    pub fn record(&mut self, seconds: f64) {
        for (count, rate) in self.0.iter_mut().zip(RATES_HZ) {
            *count += usize::from(seconds > 1.0 / rate);
        }
    }

    /// The counts, in the order of [`RATES_HZ`].
    #[must_use]
    pub const fn counts(self) -> [usize; RATES_HZ.len()] {
        self.0
    }
}
