//! Decisions at single observations: those that the navigator rejects, and those with a speed limit.

use inbye::geometry::{Point, Pose, Twist};
use inbye::local::CpuEngine;
use inbye::map::{GridFrame, ObstacleGrid, Scan, ScanError};
use inbye::navigator::{Goal, Mode, Navigator, Observation, ObservationFault, Waypoints};
use inbye::runtime::Config;

const BEAMS: usize = 360;

fn navigator() -> Navigator {
    let frame = GridFrame::new(100, 100, 0.1, Pose::default()).expect("a small map");
    let (start, goal) = (Point::new(3.0, 5.0), Point::new(7.0, 5.0));
    let known = ObstacleGrid::filled(frame, false);
    let waypoints = Waypoints { start, goals: vec![Goal::at(goal)] };
    let engine = Box::new(CpuEngine::single_threaded());
    let navigator = Config::default().new_navigator(known, &waypoints, engine, &mut || 0.0);
    navigator.expect("a path through free space")
}

/// What a robot in free space observes at its start.
fn observation(time_s: f64, twist: Twist) -> Observation {
    let all_around = (0..BEAMS).map(|beam| (f64::from(beam as u32).to_radians(), f64::INFINITY));
    Observation {
        time_s,
        pose: Pose::new(3.0, 5.0, 0.0),
        pose_s: time_s,
        lost: None,
        twist,
        odometry_s: time_s,
        scan: Scan::from_measurements(BEAMS, 12.0, all_around),
        scan_s: time_s,
        scan_changed_s: time_s,
        sent: None,
    }
}

#[test]
fn finite_speeds_that_no_base_reaches_are_a_fault() {
    for twist in [
        Twist::new(1e300, 0.0),
        Twist::new(-100.1, 0.0),
        Twist::new(0.0, 1e9),
        Twist::new(0.0, -f64::MAX),
    ] {
        let mut navigator = navigator();
        let decision = navigator.step(&observation(0.0, twist));
        assert_eq!(navigator.observation_fault(), Some(ObservationFault::TooFast), "{twist:?}");
        assert_eq!((decision.mode, decision.command), (Mode::SensorFault, Twist::STOP));
    }
    for twist in [Twist::STOP, Twist::new(0.5, -0.5), Twist::new(99.0, 0.0)] {
        let mut navigator = navigator();
        navigator.step(&observation(0.0, twist));
        assert_eq!(navigator.observation_fault(), None, "{twist:?}");
    }
}

#[test]
fn scan_whose_largest_range_is_not_above_zero_is_a_fault() {
    for range_max in [-1.0, 0.0, f64::NAN] {
        let mut navigator = navigator();
        let mut observation = observation(0.0, Twist::STOP);
        observation.scan.range_max = range_max;
        let decision = navigator.step(&observation);
        let fault = ObservationFault::InvalidScan(ScanError::LargestRange);
        assert_eq!(navigator.observation_fault(), Some(fault), "{range_max}");
        assert_eq!((decision.mode, decision.command), (Mode::SensorFault, Twist::STOP));
    }
}

#[test]
fn speed_limit_of_zero_or_less_brakes_and_stops_the_robot() {
    for limit in [0.0, -0.0, -1.0, f64::NAN] {
        let mut navigator = navigator();
        let mut twist = Twist::new(0.5, 0.0);
        for tick in 0..30 {
            navigator.set_speed_limit(Some(limit));
            twist = navigator.step(&observation(0.1 * f64::from(tick), twist)).command;
            assert!(twist.is_finite(), "{limit}: {twist:?} at tick {tick}");
        }
        assert_eq!(twist, Twist::STOP, "{limit}");
        navigator.set_speed_limit(None);
        let decision = navigator.step(&observation(3.0, twist));
        assert!(decision.command.linear > 0.0, "{limit}: {decision:?}");
    }
}

/// The robot does not give up after the time without progress that it may have, 90 s, but goes on.
#[test]
fn speed_limit_of_zero_pauses_the_mission() {
    let mut navigator = navigator();
    navigator.set_speed_limit(Some(0.0));
    for second in 0..200 {
        let decision = navigator.step(&observation(f64::from(second), Twist::STOP));
        assert_ne!(decision.mode, Mode::Failed, "after {second} s: {:?}", navigator.fault());
    }
    navigator.set_speed_limit(None);
    let decision = navigator.step(&observation(200.0, Twist::STOP));
    assert!(decision.command.linear > 0.0, "{decision:?}");
}

#[test]
fn late_observation_lets_the_robot_brake_for_the_time_since_the_one_before() {
    for elapsed_s in [0.1, 0.25, 0.5] {
        let mut navigator = navigator();
        let mut twist = Twist::new(0.8, 0.0);
        for tick in 0..3 {
            twist = navigator.step(&observation(0.1 * f64::from(tick), twist)).command;
        }
        assert!(twist.linear > 0.6, "{twist:?}");
        let mut stale = observation(0.2 + elapsed_s, twist);
        stale.odometry_s = f64::NAN;
        let braked = navigator.step(&stale).command;
        let fall = twist.linear - braked.linear;
        assert!((fall - elapsed_s).abs() < 1e-9, "{elapsed_s} s: {twist:?} {braked:?}");
        let late_ticks = u64::from(elapsed_s > 0.2);
        assert_eq!(navigator.tick_clock().late_ticks(), late_ticks, "{elapsed_s}");
    }
}

/// Observations that come every 0.25 s instead of every 0.1 s: a speed limit of zero stops the robot in the same time.
#[test]
fn dynamic_window_of_late_observations_reaches_the_braked_speeds() {
    let mut navigator = navigator();
    navigator.set_speed_limit(Some(0.0));
    let mut twist = Twist::new(0.9, 0.0);
    navigator.step(&observation(0.0, twist));
    for tick in 1..=4 {
        let last = twist.linear;
        let mut seen = observation(0.25 * f64::from(tick), twist);
        seen.sent = Some(twist);
        twist = navigator.step(&seen).command;
        assert!(last - twist.linear > 0.2 || twist.linear < 0.01, "{tick}: {last} {twist:?}");
    }
    assert!(twist.linear < 0.01, "{twist:?}");
}
