//! Percentiles of times, and missed deadlines.

use inbye::bench::{Latencies, Misses, percentile};

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

#[test]
fn decision_is_late_when_longer_than_the_period() {
    let mut misses = Misses::default();
    for seconds in [0.0, 0.009, 0.010, 0.011, 0.02, 0.021, 0.05, 0.051, 3.0] {
        misses.record(seconds);
    }
    assert_eq!(misses.counts(), [2, 4, 6]);
}

#[test]
fn percentiles_lie_on_the_line_between_two_values() {
    let values = || (1..=21).rev().map(f64::from).collect();
    assert_eq!(percentile(values(), 0.95), Some(20.0));
    assert_eq!(percentile(values(), 1.0), Some(21.0));
    assert_eq!(percentile(values(), 0.0), Some(1.0));
    assert_eq!(percentile(vec![1.0, 2.0, 3.0, 5.0], 0.75), Some(3.5));
    assert_eq!(percentile(Vec::new(), 0.5), None);
    // The median of two is their mean.
    assert_eq!(percentile(vec![3.0, 1.0], 0.5), Some(2.0));
    assert_eq!(percentile(vec![f64::INFINITY; 2], 0.5), Some(f64::INFINITY));
    assert_eq!(percentile(vec![5.0, 1.0, 4.0], 0.5), Some(4.0));
}
