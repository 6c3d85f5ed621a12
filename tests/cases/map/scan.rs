//! Lidar scans.

use inbye::geometry::Pose;
use inbye::localization::{DeskewedScan, PoseHistory};
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

fn deskewed(scan: &Scan, turn: f64) -> Scan {
    let mut history = PoseHistory::new();
    history.record(0.0, &Pose::default());
    history.record(0.1, &Pose::new(0.0, 0.0, turn));
    let mut deskewed = DeskewedScan::default();
    deskewed.deskew(&TimedScan::from_scan(scan, 0.1, 0.1), &history);
    deskewed.to_scan(scan.ranges.len())
}

#[test]
fn deskewed_scan_keeps_the_field_of_view() {
    use core::f64::consts::PI;
    for (from, beams) in [(-0.75 * PI, 271), (-0.5 * PI, 181), (0.6 * PI, 271)] {
        let mut scan = Scan {
            angle_min: from,
            angle_increment: PI / 180.0,
            range_max: 20.0,
            ranges: (0..beams).map(|beam| 1.0 + 0.01 * f64::from(beam)).collect(),
        };
        (scan.ranges[3], scan.ranges[7]) = (f64::INFINITY, f64::NAN);
        let still = deskewed(&scan, 0.0);
        assert_eq!(still.ranges.len(), scan.ranges.len(), "{from}");
        for (beam, (range, kept)) in scan.ranges.iter().zip(&still.ranges).enumerate() {
            let same =
                range == kept || (range - kept).abs() < 1e-9 || range.is_nan() && kept.is_nan();
            let off = inbye::geometry::wrap_angle(scan.angle(beam) - still.angle(beam));
            assert!(same && off.abs() < 1e-9, "beam {beam}: {range} m, {kept} m");
        }
        // The first beams are turned by 6 degrees out of the field.
        let turned = deskewed(&scan, 0.105);
        assert_eq!(turned.ranges.len(), scan.ranges.len() + 6);
    }
    let mut full = Scan {
        angle_min: -PI,
        angle_increment: PI / 180.0,
        range_max: 20.0,
        ranges: vec![2.0; 360],
    };
    full.ranges[100..200].fill(f64::NAN);
    assert_eq!(deskewed(&full, 0.0).ranges.len(), 360, "measurements are missing, not beams");
}
