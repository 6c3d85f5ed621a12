//! Perception over a log: a person walks past a robot, and a box that stood there is taken away.

use core::f64::consts::{PI, TAU};

use inbye::bench::{LogPerception, perceive_log};
use inbye::geometry::Pose;
use inbye::lidar_log::{LidarLog, LogFormat, LogRecord, LoggedScan};
use inbye::map::{Beam, TimedScan};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

const BEAMS: u32 = 720;
const PERIOD_S: f64 = 0.1;
/// Half the sides of the room, metres.
const ROOM_M: (f64, f64) = (4.0, 3.0);
/// The box until it is taken away, seconds.
const BOX: (f64, f64, f64) = (2.0, 1.0, 0.3);
const BOX_UNTIL_S: f64 = 5.0;
const SECONDS: f64 = 10.0;

/// The range along a direction to the room's walls and to discs by place and radius, metres.
fn range_to(angle: f64, discs: &[(f64, f64, f64)]) -> f64 {
    let (sin, cos) = libm::sincos(angle);
    let walls = (ROOM_M.0 / cos.abs()).min(ROOM_M.1 / sin.abs());
    let to_disc = |&(x, y, radius): &(f64, f64, f64)| {
        let (along, across) = (x * cos + y * sin, y * cos - x * sin);
        let half = radius * radius - across * across;
        if half >= 0.0 && along > 0.0 { along - half.sqrt() } else { f64::INFINITY }
    };
    discs.iter().map(to_disc).fold(walls, f64::min)
}

/// A log of a robot that stands in the middle of the room. This share of the beams has no measurement.
fn log(unmeasured: f64, has_person: bool) -> LidarLog {
    let mut rng = Pcg64Mcg::seed_from_u64(5);
    let scan_at = |tick: u32| {
        let time_s = f64::from(tick) * PERIOD_S;
        let mut discs = Vec::new();
        if time_s < BOX_UNTIL_S {
            discs.push(BOX);
        }
        if has_person {
            discs.push((-3.0 + 0.6 * time_s, -2.0, 0.25));
        }
        let beam = |number: u32| {
            let angle = -PI + f64::from(number) * TAU / f64::from(BEAMS);
            let noise_m = rng.random_range(-0.01..0.01);
            let is_measured = rng.random::<f64>() >= unmeasured;
            let range = if is_measured { range_to(angle, &discs) + noise_m } else { f64::NAN };
            Beam { angle, range, time_s }
        };
        let beams = TimedScan {
            beams: (0..BEAMS).map(beam).collect(),
            range_max: 10.0,
            ..TimedScan::default()
        };
        LogRecord {
            time_s,
            odometry: Pose::default(),
            corrected: None,
            scan: Some(LoggedScan { mount: Pose::default(), beams }),
        }
    };
    let records = (0..(SECONDS / PERIOD_S) as u32).map(scan_at).collect();
    LidarLog { format: LogFormat::Carmen, records, has_times: true, cut_line: None }
}

fn perceived(unmeasured: f64, has_person: bool) -> LogPerception {
    let mut calls = 0.0;
    let mut clock = || {
        calls += 1e-6;
        calls
    };
    perceive_log(&log(unmeasured, has_person), &mut clock).expect("a small map")
}

#[test]
fn person_who_walks_moves_and_nothing_else_does() {
    for (has_person, moving) in [(true, 1), (false, 0)] {
        let result = perceived(0.0, has_person);
        assert_eq!((result.scans, result.format), (100, LogFormat::Carmen));
        assert!((result.tracked_s - 9.9).abs() < 1e-9, "{}", result.tracked_s);
        for one in [&result.unknown, &result.mapped] {
            assert_eq!((one.moving, one.on_surfaces), (moving, 0), "{one:?}");
            let expected = moving as f64 * 60.0 / result.tracked_s;
            assert_eq!(one.moving_per_min, Some(expected));
        }
        let walked_s = result.unknown.moving_s;
        assert_eq!(walked_s > 5.0, has_person, "{walked_s}");
    }
}

/// Surfaces that give no echo leave gaps in every scan of a real lidar.
#[test]
fn marks_of_a_departed_box_go_within_half_a_second_also_with_gaps_in_the_scans() {
    for unmeasured in [0.0, 0.15] {
        let result = perceived(unmeasured, false);
        assert!((result.unmeasured - unmeasured).abs() < 0.01, "{}", result.unmeasured);
        let unknown = &result.unknown;
        assert!(unknown.cleared >= 8, "the near side of the box: {unknown:?}");
        let in_time = unknown.cleared_in_time.expect("some");
        assert!(in_time >= 0.9, "{unmeasured}: {unknown:?}");
        // Walls are marks too: the map is empty.
        assert!(unknown.marks > 100.0, "{unknown:?}");
    }
}
