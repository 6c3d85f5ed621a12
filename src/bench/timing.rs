//! Percentiles of many times, from a histogram of fixed size.

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
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LatencySummary {
    /// Times recorded, at least one.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn summary_has_the_percentiles_of_known_times() {
        let mut latencies = Latencies::default();
        // Each value once, out of order: 7 and 1000 have no common factor.
        for index in 0..1000 {
            let microseconds = f64::from(index * 7 % 1000 + 1);
            latencies.record(microseconds * 1e-6).expect("finite and in range");
        }
        let summary = latencies.summary().expect("finite and in range");
        assert_eq!(summary.count, 1000);
        for (measured, expected) in [
            (summary.p50_ms, 0.500),
            (summary.p95_ms, 0.950),
            (summary.p99_ms, 0.990),
            (summary.max_ms, 1.000),
        ] {
            assert!(
                (measured / expected - 1.0).abs() < 1e-3,
                "{measured} is not within 0.1 % of {expected}"
            );
        }
    }

    #[test]
    fn merge_adds_all_times() {
        let record = |milliseconds: [f64; 2]| {
            let mut latencies = Latencies::default();
            for time in milliseconds {
                latencies.record(time * 1e-3).expect("in range");
            }
            latencies
        };
        let mut merged = record([1.0, 4.0]);
        merged.merge(&record([2.0, 3_600_000.0]));
        assert_eq!(merged.count(), 4);
        let middle = merged.quantile_ms(0.5).expect("four times");
        assert!((middle / 2.0 - 1.0).abs() < 1e-3, "{middle}");
    }

    #[test]
    fn summary_is_none_without_times() {
        assert_eq!(Latencies::default().summary(), None);
    }

    #[test]
    fn record_rejects_times_that_no_clock_measures() {
        let mut latencies = Latencies::default();
        for seconds in [f64::NAN, f64::INFINITY, -1e-9] {
            assert!(latencies.record(seconds).is_err(), "{seconds}");
        }
        assert_eq!(latencies.count(), 0);
        assert!(latencies.record(0.0).is_ok() && latencies.record(1e300).is_ok());
    }

    #[test]
    fn summary_has_the_field_names_of_the_command_line() {
        let mut latencies = Latencies::default();
        latencies.record(0.001).expect("finite and in range");
        let json = serde_json::to_value(latencies.summary()).expect("finite and in range");
        for field in ["count", "p50", "p95", "p99", "max"] {
            assert!(json.get(field).is_some(), "{field}");
        }
    }
}
