//! Each age and each stamp, just below its limit and just above it.

use super::*;
use crate::map::{GridFrame, OccupancyGrid};
use crate::ros::msg::{self, Header, TFMessage, Transform, TransformStamped};

const START_S: f64 = 100.0;
const LIMITS: AgeLimits = AgeLimits { odometry_s: 0.3, transform_s: 0.3, clock_ahead_s: 0.1 };
const BEAMS: usize = 60;

fn header(frame_id: &str, time_s: f64) -> Header {
    Header { stamp: Time::from_seconds(time_s), frame_id: frame_id.to_owned() }
}

fn transform(parent: &str, child: &str, time_s: f64) -> TFMessage {
    let transform = Transform::from(&Pose::default());
    let child_frame_id = child.to_owned();
    TFMessage {
        transforms: vec![TransformStamped {
            header: header(parent, time_s),
            child_frame_id,
            transform,
        }],
    }
}

fn odometry(stamp_s: f64) -> Odometry {
    Odometry {
        header: header("odom", stamp_s),
        child_frame_id: "base_link".to_owned(),
        ..Odometry::default()
    }
}

fn scan(stamp_s: f64) -> LaserScan {
    LaserScan {
        header: header("laser", stamp_s),
        angle_max: 0.1 * (BEAMS - 1) as f32,
        angle_increment: 0.1,
        range_max: 12.0,
        ranges: vec![5.0; BEAMS],
        ..LaserScan::default()
    }
}

fn observe(
    inputs: &LatestInputs,
    now_s: f64,
    frame: &OdometryFrame,
) -> Result<Observation, MissingInput> {
    let ready = inputs.ready(now_s, &LIMITS, frame)?;
    Ok(inputs.observation(now_s, &ready).expect("odometry and a scan"))
}

/// Inputs that all arrived at the start. The stamps of odometry and scan are ahead of it by these times, seconds.
fn arrived(odometry_ahead_s: f64, scan_ahead_s: f64) -> LatestInputs {
    let frame = GridFrame::new(1, 1, 1.0, Pose::default()).expect("a frame");
    let grid = OccupancyGrid::new(frame, vec![0]);
    let map = Some(MapInput { frame: "map".to_owned(), grid });
    let mut inputs = LatestInputs { map, ..LatestInputs::default() };
    for (parent, child) in [("map", "odom"), ("base_link", "laser")] {
        let message = transform(parent, child, START_S);
        inputs.frames.update(START_S, &message, false).expect("valid");
    }
    let moved = odometry(START_S + odometry_ahead_s);
    inputs.set_odometry(START_S, &moved, &LIMITS).expect("valid");
    inputs.set_scan(START_S, &scan(START_S + scan_ahead_s), &LIMITS).expect("valid");
    inputs
}

/// What is missing at a time after the start, seconds, after these frames were updated.
fn missing(after_s: f64, renewed: &[(&str, &str)]) -> Option<MissingInput> {
    let now_s = START_S + after_s;
    let mut inputs = arrived(0.0, 0.0);
    if !renewed.is_empty() {
        inputs.set_odometry(now_s, &odometry(now_s), &LIMITS).expect("valid");
    }
    for (parent, child) in renewed {
        inputs.frames.update(now_s, &transform(parent, child, now_s), false).expect("valid");
    }
    observe(&inputs, now_s, &OdometryFrame::ByTransforms).err()
}

#[test]
fn each_input_expires_by_its_own_stamp() {
    let (odom, laser) = (("map", "odom"), ("base_link", "laser"));
    assert_eq!(missing(0.29, &[]), None);
    assert_eq!(missing(0.31, &[]), Some(MissingInput::RecentOdometry));
    assert_eq!(missing(0.31, &[odom, laser]), None);
    for (renewed, (ancestor, frame)) in [(laser, odom), (odom, laser)] {
        let (frame, ancestor) = (frame.to_owned(), ancestor.to_owned());
        let old = MissingInput::RecentTransform { frame, ancestor };
        assert_eq!(missing(0.31, &[renewed]), Some(old));
        assert_eq!(missing(0.29, &[renewed]), None);
    }
}

#[test]
fn input_from_a_clock_ahead_is_as_old_as_its_arrival() {
    let inputs = arrived(0.09, 0.08);
    let at = |after_s: f64| observe(&inputs, START_S + after_s, &OdometryFrame::IsMap);
    let seen = at(0.29).expect("fresh");
    for stamp_s in [seen.odometry_s, seen.scan_s, seen.scan_changed_s] {
        assert!((stamp_s - START_S).abs() < 1e-6, "{stamp_s}");
    }
    assert_eq!(at(0.31).err(), Some(MissingInput::RecentOdometry));
}

/// Messages that arrive in time with old stamps are another fault than none.
#[test]
fn old_odometry_that_is_received_is_reported_as_such() {
    let inputs = arrived(-0.25, 0.0);
    let at = |after_s: f64| observe(&inputs, START_S + after_s, &OdometryFrame::IsMap).err();
    assert_eq!(at(0.04), None);
    assert_eq!(at(0.06), Some(MissingInput::OldOdometry));
    assert_eq!(at(0.31), Some(MissingInput::RecentOdometry));
}

#[test]
fn raw_scan_and_motion_of_a_clock_ahead_are_as_old_as_their_arrival() {
    let inputs = arrived(0.09, 0.08);
    let raw = inputs.raw_scan(START_S, &LIMITS).expect("a scan");
    let end_s = raw.end_s().expect("beams");
    assert!((end_s - START_S).abs() < 1e-6, "{end_s}");
    let (_, motion_s) = inputs.motion().expect("odometry");
    assert!((motion_s - START_S).abs() < 1e-6, "{motion_s}");
}

/// A pose in another frame is no motion: the beams of a scan between both are not moved by it.
#[test]
fn odometry_in_another_frame_does_not_continue_the_motion() {
    let mut inputs = arrived(0.0, -0.5);
    let mut elsewhere = odometry(START_S + 0.1);
    elsewhere.header.frame_id = "other".to_owned();
    elsewhere.pose.pose = msg::Pose::from(&Pose::new(10.0, 0.0, 0.0));
    inputs.set_odometry(START_S + 0.1, &elsewhere, &LIMITS).expect("valid");
    let mut message = scan(START_S + 0.02);
    message.time_increment = 0.06 / BEAMS as f32;
    inputs.set_scan(START_S + 0.1, &message, &LIMITS).expect("valid");
    let seen = observe(&inputs, START_S + 0.1, &OdometryFrame::IsMap).expect("fresh");
    let ranges = seen.scan.ranges.iter().filter(|range| range.is_finite());
    let farthest_m = ranges.copied().fold(0.0, f64::max);
    assert!((farthest_m - 5.0).abs() < 1e-6, "{farthest_m}");
}

#[test]
fn observation_has_the_stamps_and_not_the_time_of_the_tick() {
    let inputs = arrived(-0.05, -0.1);
    let seen = observe(&inputs, START_S + 0.2, &OdometryFrame::ByTransforms).expect("fresh");
    let expected = [(seen.odometry_s, -0.05), (seen.scan_s, -0.1), (seen.scan_changed_s, -0.1)];
    for (stamp_s, after_s) in expected.into_iter().chain([(seen.pose_s, 0.0)]) {
        assert!((stamp_s - START_S - after_s).abs() < 1e-6, "{stamp_s}");
    }
}

/// A driver that stamps the end of a revolution: its beams are not from the future.
#[test]
fn no_beam_is_later_than_the_arrival_of_its_scan() {
    let mut inputs = arrived(0.0, -0.5);
    let mut message = scan(START_S);
    message.time_increment = 0.1 / BEAMS as f32;
    inputs.set_scan(START_S, &message, &LIMITS).expect("valid");
    let seen = observe(&inputs, START_S, &OdometryFrame::ByTransforms).expect("fresh");
    assert!((seen.scan_s - START_S).abs() < 1e-6, "{}", seen.scan_s);
}

#[test]
fn stamps_are_set_in_order_and_not_ahead() {
    let odometry_of = |after_s: f64| {
        arrived(0.0, 0.0).set_odometry(START_S, &odometry(START_S + after_s), &LIMITS)
    };
    let scan_of =
        |after_s: f64| arrived(0.0, 0.0).set_scan(START_S, &scan(START_S + after_s), &LIMITS);
    for result in [odometry_of as fn(f64) -> Result<(), MessageError>, scan_of] {
        assert!(result(0.09).is_ok() && result(-1.1).is_ok());
        assert!(matches!(result(0.11), Err(MessageError::ClockAhead { .. })));
        assert!(matches!(result(0.0), Err(MessageError::NotNewer)));
        assert!(matches!(result(-0.5), Err(MessageError::NotNewer)));
        assert!(matches!(result(-START_S), Err(MessageError::NoStamp)));
    }
    let mut elsewhere = scan(START_S + 0.05);
    elsewhere.header.frame_id = "elsewhere".to_owned();
    let unknown = arrived(0.0, 0.0).set_scan(START_S, &elsewhere, &LIMITS);
    assert!(matches!(unknown, Err(MessageError::LidarMount { .. })));
}
