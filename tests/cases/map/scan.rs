//! Lidar scans.

use core::f64::consts::PI;

use inbye::geometry::{Point, Pose};
use inbye::localization::{DeskewedScan, PoseHistory};
use inbye::map::{Scan, TimedScan};

#[test]
fn timed_scan_from_scan_ends_at_the_given_time() {
    let scan = Scan {
        angle_min: -1.0,
        angle_increment: 0.5,
        range_max: 8.0,
        ranges: vec![1.0, f64::INFINITY, 3.0],
        ..Scan::default()
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
            ..Scan::default()
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
        // The robot turns by 6 degrees with the lidar, or against it: the field is as much wider or smaller.
        for turn in [0.105, -0.105] {
            let turned = deskewed(&scan, turn);
            let field = |scan: &Scan| (scan.ranges.len() - 1) as f64 * scan.angle_increment;
            assert!((field(&turned) - field(&scan) - turn).abs() < 1e-9, "{turn}");
            assert!((turned.angle_min - scan.angle_min + turn).abs() < 1e-9, "{turn}");
            assert_eq!(turned.ranges.iter().filter(|range| range.is_nan()).count(), 1);
        }
    }
    let mut full = Scan {
        angle_min: -PI,
        angle_increment: PI / 180.0,
        range_max: 20.0,
        ranges: vec![2.0; 360],
        ..Scan::default()
    };
    full.ranges[100..200].fill(f64::NAN);
    assert_eq!(deskewed(&full, 0.0).ranges.len(), 360, "measurements are missing, not beams");
}

/// Near and far ranges, of which some are missing: the directions of the beams do not depend on them.
#[test]
fn scan_of_a_mounted_lidar_keeps_its_points_and_its_field_of_view() {
    let ranges = [0.1, f64::NAN, 5.0, 0.0, f64::INFINITY, 2.0, 0.3, f64::NAN];
    let scan = Scan {
        angle_min: -1.5,
        angle_increment: 0.02,
        range_max: 10.0,
        ranges: ranges.into_iter().cycle().take(151).collect(),
        ..Scan::default()
    };
    for mount in [Pose::new(-0.25, 0.0, 3.0), Pose::new(0.3, 0.2, 0.785)] {
        let own: Vec<Point> = scan.hits(&mount).collect();
        let moved = scan.clone().from_mount(&mount);
        let mut still = DeskewedScan::default();
        let timed = TimedScan::from_scan(&scan, 0.0, 0.0).from_mount(&mount);
        assert_eq!((timed.origin, timed.range_max), (mount.position(), 10.0));
        still.deskew(&timed, &PoseHistory::default());
        let resampled = still.to_scan(151);
        for scan in [moved, resampled] {
            assert_eq!((scan.origin, scan.ranges.len()), (mount.position(), 151));
            let points: Vec<Point> = scan.hits(&Pose::default()).collect();
            assert_eq!(points.len(), own.len());
            let nearest = |point: &Point| {
                own.iter().map(|other| (other - point).norm()).fold(f64::INFINITY, f64::min)
            };
            assert!(points.iter().all(|point| nearest(point) < 1e-9));
        }
        // The lidar's place turns with the robot.
        let robot = Pose::new(3.0, -1.0, 2.0);
        let place = robot.transform_pose(&mount);
        let points: Vec<Point> = scan.clone().from_mount(&mount).hits(&robot).collect();
        for (point, other) in points.iter().zip(scan.hits(&place)) {
            assert!((point - other).norm() < 1e-9);
        }
    }
}

/// A grain of dust at the edge of the field, seen from 0.1 m farther back, lies behind the lidar at the time of the scan.
#[test]
fn near_return_does_not_widen_the_field_of_view() {
    let mut ranges = vec![8.0; 271];
    ranges[0] = 0.03;
    let angle_min = (-135.0_f64).to_radians();
    let angle_increment = 1.0_f64.to_radians();
    let scan = Scan { angle_min, angle_increment, range_max: 10.0, ranges, ..Scan::default() };
    let mut history = PoseHistory::new();
    history.record(0.0, &Pose::default());
    history.record(0.1, &Pose::new(0.1, 0.0, 0.0));
    let mut deskewed = DeskewedScan::default();
    deskewed.deskew(&TimedScan::from_scan(&scan, 0.1, 0.1), &history);
    let seen = deskewed.to_scan(271);
    assert_eq!(seen.ranges.len(), 271);
    assert!((seen.angle_min - angle_min).abs() < 1e-9);
    assert!((0.1..0.15).contains(&seen.ranges[0]), "{}", seen.ranges[0]);
    assert!(seen.ranges[1..].iter().filter(|range| range.is_nan()).count() <= 2);
}

/// The yaw of the odometry is within a half turn: the difference between two poses is not.
#[test]
fn turn_across_the_half_turn_keeps_the_field_of_view() {
    let (angle_min, angle_increment) = (-0.75, 0.01);
    let ranges = vec![8.0; 151];
    let scan = Scan { angle_min, angle_increment, range_max: 10.0, ranges, ..Scan::default() };
    let seen_from = |first: f64, last: f64| {
        let mut history = PoseHistory::new();
        history.record(0.0, &Pose::new(0.0, 0.0, first));
        history.record(0.1, &Pose::new(0.0, 0.0, last));
        let mut deskewed = DeskewedScan::default();
        deskewed.deskew(&TimedScan::from_scan(&scan, 0.1, 0.1), &history);
        deskewed.to_scan(151)
    };
    let (seen, across) = (seen_from(-0.05, 0.05), seen_from(PI - 0.05, 0.05 - PI));
    assert!((seen.angle_min - (angle_min - 0.1)).abs() < 1e-9, "{}", seen.angle_min);
    assert!((across.angle_min - seen.angle_min).abs() < 1e-9, "{}", across.angle_min);
    assert!((across.angle_increment - seen.angle_increment).abs() < 1e-9);
}
