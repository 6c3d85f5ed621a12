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

#[test]
fn evenly_spaced_measurements_fill_every_beam() {
    use core::f64::consts::{PI, TAU};
    for beams in [90, 360, 450, 456, 720, 1081] {
        // Directions with the errors of a sum and of a yaw, as a turning robot gives them.
        for yaw in [0.0, 1e-9, -1e-9, 0.3] {
            let direction = |beam: usize| beam as f64 * (TAU / beams as f64) - PI + yaw;
            let measured = (0..beams).map(|beam| (direction(beam) - yaw, beam as f64 + 1.0));
            let scan = Scan::from_measurements(beams, 2e3, measured);
            for (beam, range) in scan.ranges.iter().enumerate() {
                assert_eq!(*range, beam as f64 + 1.0, "beam {beam} of {beams}");
                assert!((scan.angle(beam) - (direction(beam) - yaw)).abs() < 1e-9);
            }
        }
    }
}
