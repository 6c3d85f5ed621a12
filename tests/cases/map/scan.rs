//! Lidar scans.

use inbye::map::{Scan, TimedScan};

#[test]
fn timed_scan_from_scan_ends_at_the_given_time() {
    let scan = Scan {
        angle_min: -1.0,
        angle_increment: 0.5,
        range_max: 8.0,
        ranges: vec![1.0, f64::INFINITY, 3.0],
    };
    let timed = TimedScan::from_scan(&scan, 7.0, 0.1);
    let angles: Vec<f64> = timed.beams.iter().map(|beam| beam.angle).collect();
    let times: Vec<f64> = timed.beams.iter().map(|beam| beam.time_s).collect();
    assert_eq!((angles, times), (vec![-1.0, -0.5, 0.0], vec![6.9, 6.95, 7.0]));
    assert!(timed.is_valid() && timed.end_s() == Some(7.0));
    assert_eq!(TimedScan::from_scan(&Scan::default(), 7.0, 0.1).end_s(), None);
}
