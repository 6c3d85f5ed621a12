//! Short pose history, motion compensation of a revolution, and the filter of odometry with measured poses.

use std::f64::consts::{FRAC_PI_2, PI};

use inbye::geometry::{Point, Pose, Twist, wrap_angle};
use inbye::localization::{DeskewedScan, PoseFilter, PoseHistory, PoseMeasurement};
use inbye::map::{Beam, TimedScan};

#[test]
fn pose_history_interpolates_between_poses() {
    let mut history = PoseHistory::new();
    assert_eq!(history.at(0.0), None);
    history.record(1.0, &Pose::new(0.0, 0.0, 0.0));
    history.record(1.1, &Pose::new(0.1, 0.0, 0.0));
    let at = |time_s: f64| history.at(time_s).expect("two poses").x;
    assert_eq!([at(0.5), at(1.0), at(1.1), at(9.0)], [0.0, 0.0, 0.1, 0.1]);
    assert!((at(1.025) - 0.025).abs() < 1e-12);
}

#[test]
fn pose_history_drops_old_poses_and_restarts_when_time_decreases() {
    let mut history = PoseHistory::new();
    for tick in 0..100_000 {
        history.record(0.01 * f64::from(tick), &Pose::new(f64::from(tick), 0.0, 0.0));
    }
    // A time before the history gives its first pose.
    let first = history.at(0.0).expect("the last second").x;
    assert!(first > 99_999.0 - 109.0, "{first}");
    history.record(f64::NAN, &Pose::default());
    history.record(5.0, &Pose::new(f64::NAN, 0.0, 0.0));
    assert_eq!(history.newest().map(|(_, pose)| pose.x), Some(99_999.0));
    history.record(5.0, &Pose::default());
    history.record(5.0, &Pose::new(7.0, 0.0, 0.0));
    for time_s in [0.0, 5.0, 9.0] {
        assert_eq!(history.at(time_s).map(|pose| pose.x), Some(7.0));
    }
}

/// A robot drives a curve while its lidar turns; a post stays at the same place in every beam.
#[test]
fn deskewing_removes_motion_distortion_of_a_post() {
    let (mut history, twist) = (PoseHistory::new(), Twist::new(1.0, 0.8));
    let start = Pose::new(4.0, 2.0, -1.0);
    (0..=10).for_each(|tick| {
        let time_s = 0.01 * f64::from(tick);
        history.record(time_s, &start.after(&twist, time_s));
    });
    let post = Point::new(6.0, 1.0);
    let beam = |index: u32| {
        let time_s = 0.001 * f64::from(index);
        let seen = start.after(&twist, time_s).inverse_transform(&post);
        Beam { angle: libm::atan2(seen.y, seen.x), range: seen.to_vector().norm(), time_s }
    };
    let mut timed =
        TimedScan { beams: (0..=100).map(beam).collect(), range_max: 10.0, ..TimedScan::default() };
    timed.beams[50].range = f64::INFINITY;
    timed.beams[51].range = f64::NAN;
    timed.beams[52].range = -1.0;
    let mut deskewed = DeskewedScan::default();
    deskewed.deskew(&timed, &history);
    assert_eq!((deskewed.hits.len(), deskewed.open.len(), deskewed.unmeasured), (98, 1, 2));
    let here = start.after(&twist, 0.1);
    for hit in &deskewed.hits {
        assert!((here.transform(&hit.end) - post).norm() < 1e-9);
    }
    // Without deskewing, the ends are spread over centimetres.
    let raw = &timed.beams[0];
    let (sin, cos) = libm::sincos(raw.angle);
    let smeared = here.transform(&Point::new(raw.range * cos, raw.range * sin));
    assert!((smeared - post).norm() > 0.05);
    let scan = deskewed.to_scan(360);
    let ends: Vec<Point> = scan.hits(&here).collect();
    assert!(!ends.is_empty());
    // Within half a beam's angle.
    assert!(ends.iter().all(|end| (end - post).norm() < 0.03), "{ends:?}");
}

const START: PoseMeasurement =
    PoseMeasurement { pose: Pose::new(3.0, -2.0, FRAC_PI_2), sigma_m: 0.01, sigma_rad: 0.005 };

/// A quarter circle to the left of radius 2 m, in its own frame.
fn arc(step: u32) -> Pose {
    let angle = FRAC_PI_2 * f64::from(step) / 100.0;
    let (sin, cos) = libm::sincos(angle);
    Pose::new(2.0 * sin, 2.0 * (1.0 - cos), angle)
}

#[test]
fn prediction_alone_is_odometry_from_the_start_with_growing_uncertainty() {
    let mut filter = PoseFilter::new(&START);
    (0..=100).for_each(|step| filter.predict(&arc(step)));
    let pose = *filter.pose();
    assert!((pose.x - 1.0).abs() < 1e-12 && pose.y.abs() < 1e-12, "{pose:?}");
    assert!((wrap_angle(pose.yaw).abs() - PI).abs() < 1e-12);
    // The standard deviation is between 2 and 8 cm: a position further off than 4.6 of them is an outlier.
    let accepts = |sigma_m: f64| {
        let pose = Pose { y: pose.y + 4.6 * sigma_m, ..pose };
        filter.clone().correct(&PoseMeasurement { pose, sigma_m: 1e-3, sigma_rad: 1.0 })
    };
    assert!(accepts(0.02) && !accepts(0.08));
}

#[test]
fn corrections_remove_odometry_drift() {
    let mut filter = PoseFilter::new(&START);
    for step in 0..=100 {
        // Odometry that measures 5 % too much.
        let true_pose = arc(step);
        filter.predict(&Pose::new(1.05 * true_pose.x, 1.05 * true_pose.y, true_pose.yaw));
        let pose = START.pose.transform_pose(&true_pose);
        assert!(filter.correct(&PoseMeasurement { pose, ..START }));
    }
    let pose = filter.pose();
    assert!((pose.x - 1.0).abs() < 5e-3 && pose.y.abs() < 5e-3, "{pose:?}");
}

#[test]
fn outlier_is_rejected_until_ten_agree() {
    let mut filter = PoseFilter::new(&START);
    let outlier = PoseMeasurement { pose: Pose::new(4.0, -2.0, FRAC_PI_2), ..START };
    for _ in 1..10 {
        assert!(!filter.correct(&outlier));
        assert_eq!(*filter.pose(), START.pose);
    }
    assert!(filter.correct(&outlier));
    assert_eq!(*filter.pose(), outlier.pose);
    let nan = PoseMeasurement { pose: Pose::new(f64::NAN, 0.0, 0.0), ..START };
    assert!(!filter.correct(&nan));
    filter.predict(&Pose::new(f64::INFINITY, 0.0, 0.0));
    assert_eq!(*filter.pose(), outlier.pose);
}
