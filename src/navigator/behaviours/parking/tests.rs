//! Tests of parking on a base that rounds small commands to zero.

use super::*;
use crate::geometry::Point;

/// A base that follows commands within its limits, some ticks late, and rounds small ones to zero.
#[derive(Clone, Copy)]
struct Base {
    limits: Limits,
    deadband: f64,
    late_ticks: usize,
}

/// A least speed of the base, at least that of the settings.
const DEADBAND: f64 = 0.02;
const PERIOD_S: f64 = 0.1;

/// Parks a base. Returns the pose and the twist where it was parked, and the time, seconds.
fn park(base: &Base, start: Pose, goal: Goal) -> (Pose, Twist, f64) {
    park_by(Parking::default(), &NavigatorSettings::default(), base, start, goal)
}

fn park_by(
    mut parking: Parking,
    settings: &NavigatorSettings,
    base: &Base,
    start: Pose,
    goal: Goal,
) -> (Pose, Twist, f64) {
    let (mut pose, mut twist) = (start, Twist::STOP);
    let mut sent = Twist::STOP;
    let mut late = std::collections::VecDeque::from(vec![Twist::STOP; base.late_ticks]);
    let rounded = |speed: f64| if speed.abs() < base.deadband { 0.0 } else { speed };
    for tick in 0..600 {
        let time_s = f64::from(tick) * PERIOD_S;
        let motion = Motion { time_s, pose: &pose, twist: &twist, measured: &twist, sent: &sent };
        let next = parking.next(motion, &goal, (settings, &base.limits, PERIOD_S));
        let Some(wanted) = next else {
            return (pose, twist, time_s);
        };
        sent = wanted;
        for (speed, least) in [(wanted.linear, 0.05), (wanted.angular, 0.08)] {
            let is_in_place = wanted.linear == 0.0 || speed == wanted.linear;
            assert!(!is_in_place || speed == 0.0 || speed.abs() >= least, "{wanted:?}");
        }
        late.push_back(base.limits.clamp(&wanted));
        let command = late.pop_front().unwrap_or_default();
        let command = Twist::new(rounded(command.linear), rounded(command.angular));
        let before = twist;
        twist = base.limits.reachable(&twist, &command, PERIOD_S);
        let mean = |one: f64, other: f64| f64::midpoint(one, other);
        let moved =
            Twist::new(mean(before.linear, twist.linear), mean(before.angular, twist.angular));
        pose = pose.after(&moved, PERIOD_S);
    }
    panic!("not parked after 60 s: {pose:?}");
}

#[test]
fn parking_reaches_position_and_yaw_from_all_directions_at_each_deadband() {
    let mut slowest_s: f64 = 0.0;
    for (least, deadband, late_ticks) in
        [(-0.3, 0.0, 1), (-0.3, DEADBAND, 1), (0.0, DEADBAND, 1), (-0.3, DEADBAND, 2)]
    {
        let limits = Limits { min_vel_x: least, ..Limits::default() };
        let base = Base { limits, deadband, late_ticks };
        for step in 0..48_u32 {
            let (around, yaw) = (f64::from(step) * 0.131, f64::from(step) * 0.77);
            let start = Pose::new(0.3 * libm::cos(around), 0.3 * libm::sin(around), yaw);
            let goal = Goal {
                position: Point::new(0.0, 0.0),
                yaw: (step % 3 > 0).then_some(wrap_angle(yaw + 2.0)),
            };
            let (end, twist, took_s) = park(&base, start, goal);
            let off_m = end.position().to_vector().norm();
            let off = goal.yaw.map_or(0.0, |yaw| wrap_angle(yaw - end.yaw));
            let case = format!("{least} {deadband} {late_ticks} {step}: {took_s} s");
            assert!(off_m <= 0.02, "{case}: {off_m} m");
            assert!(off.abs() <= 0.01, "{case}: {off} rad");
            assert_eq!(twist, Twist::STOP, "{case}");
            slowest_s = slowest_s.max(took_s);
        }
    }
    assert!(slowest_s < 20.0, "{slowest_s} s");
}

#[test]
fn hurried_robot_parks_sooner_within_the_tolerances_of_its_goal() {
    let base = Base { limits: Limits::default(), deadband: DEADBAND, late_ticks: 1 };
    for (yaw, most_off) in [(None, 0.0), (Some(1.5), 0.05), (Some(-2.5), 0.05)] {
        let goal = Goal { position: Point::new(0.9, 0.1), yaw };
        let (hurried, settings) = (Parking::new(true), NavigatorSettings::default());
        let (end, twist, took_s) = park_by(hurried, &settings, &base, Pose::default(), goal);
        let (.., usual_s) = park(&base, Pose::default(), goal);
        assert_eq!(twist, Twist::STOP);
        assert!(took_s < usual_s - 0.9, "{took_s} s instead of {usual_s} s");
        assert!((end.position() - goal.position).norm() <= 0.125, "{end:?}");
        let off = yaw.map_or(0.0, |yaw| wrap_angle(yaw - end.yaw));
        assert!(off.abs() <= most_off, "{off} rad");
    }
}

/// A robot with coarse tolerances stops within them, and turns only as far as it must.
#[test]
fn robot_with_coarse_tolerances_brakes_within_them() {
    let base = Base { limits: Limits::default(), deadband: DEADBAND, late_ticks: 1 };
    let goal = Goal { position: Point::new(0.9, 0.1), yaw: Some(1.5) };
    let coarse = NavigatorSettings {
        xy_parking_tolerance: 0.2,
        yaw_parking_tolerance: 0.08,
        ..NavigatorSettings::default()
    };
    let parking = Parking::default();
    let (end, twist, took_s) = park_by(parking, &coarse, &base, Pose::default(), goal);
    let (.., usual_s) = park(&base, Pose::default(), goal);
    assert_eq!(twist, Twist::STOP);
    assert!(took_s < usual_s - 0.9, "{took_s} s instead of {usual_s} s");
    let off_m = (end.position() - goal.position).norm();
    assert!((0.01..=0.2).contains(&off_m), "{end:?}");
    assert!((end.yaw - 1.5).abs() <= 0.08, "{end:?}");
}

/// The tolerances grow while a robot parks. The same goal again must not make it correct the rest.
#[test]
fn robot_that_stands_at_its_goal_stays_or_turns() {
    let base = Base { limits: Limits::default(), deadband: DEADBAND, late_ticks: 1 };
    let (far, near) = (Point::new(-0.01, 0.015), Point::new(-0.004, 0.006));
    for (off, yaw, turn) in
        [(far, None, 0.0), (far, Some(0.4), 0.0), (far, Some(0.408), 0.0), (near, Some(0.7), 0.3)]
    {
        let start = Pose::new(off.x, off.y, 0.4);
        let goal = Goal { position: Point::new(0.0, 0.0), yaw };
        let (end, _, took_s) = park(&base, start, goal);
        assert_eq!(end.position(), off, "{yaw:?}");
        assert!((end.yaw - 0.4 - turn).abs() <= 0.01, "{yaw:?}: {end:?}");
        assert_eq!(took_s < 0.5, turn == 0.0, "{yaw:?}: {took_s} s");
    }
}

#[test]
fn parking_reverses_to_a_goal_behind_if_the_base_can() {
    let goal = Goal::at(Point::new(-0.2, 0.0));
    for (least, backs) in [(-0.3, true), (0.0, false)] {
        let limits = Limits { min_vel_x: least, ..Limits::default() };
        let base = Base { limits, deadband: DEADBAND, late_ticks: 1 };
        let (end, ..) = park(&base, Pose::default(), goal);
        assert_eq!(end.yaw.abs() < 0.1, backs, "{end:?}");
    }
}

#[test]
fn parking_learns_the_least_speed_of_the_base() {
    let base = Base { limits: Limits::default(), deadband: 0.15, late_ticks: 1 };
    let goal = Goal { position: Point::new(0.0, 0.0), yaw: Some(0.05) };
    let (end, _, took_s) = park(&base, Pose::default(), goal);
    assert!((end.yaw - 0.05).abs() < 0.02 && took_s < 10.0, "{end:?} after {took_s} s");
}

#[test]
fn turning_base_is_not_parked_where_its_measured_rate_crosses_zero() {
    let settings = NavigatorSettings::default();
    let (pose, limits, mut parking) = (Pose::default(), Limits::default(), Parking::default());
    let goal = Goal { position: Point::new(0.0, 0.0), yaw: Some(0.0) };
    let mut is_parked = |tick: u32, rate: f64| {
        let (time_s, twist) = (f64::from(tick) * PERIOD_S, Twist::new(0.0, rate));
        let (still, measured) = (Twist::STOP, &twist);
        let motion = Motion { time_s, pose: &pose, twist: &still, measured, sent: &still };
        parking.next(motion, &goal, (&settings, &limits, PERIOD_S)).is_none()
    };
    for tick in 0..20 {
        // The rate changes its sign at every second tick: it is zero for one tick.
        let rate = if tick % 2 == 0 { 0.0 } else { 0.1 };
        assert!(!is_parked(tick, rate), "parked at tick {tick}");
    }
    let parked = (20..30).find(|tick| is_parked(*tick, 0.0));
    assert_eq!(parked, Some(23), "0.3 s of standing");
}
