//! How an emulated machine differs from its settings, and faults of its sensors, its controller and its line.

use inbye::base::{
    BaseSettings, Emulator, Faults, InjectedFault, Protocol, ScheduledFault, StopCause,
};
use inbye::geometry::Twist;
use inbye::robot::Side;

use super::emulator::Pair;

const AHEAD: Twist = Twist::new(0.4, 0.0);
const CURVE: Twist = Twist::new(0.4, 0.3);

fn with(fault: InjectedFault, from_s: f64, to_s: f64) -> Pair {
    Pair::with(Protocol::Native, &[ScheduledFault { fault, from_s, to_s }])
}

fn from(fault: InjectedFault) -> Pair {
    with(fault, 1.0, f64::INFINITY)
}

/// A pair whose machine differs from the settings.
fn differing(change: impl Fn(Emulator) -> Emulator) -> Pair {
    let mut pair = Pair::new(Protocol::Native, 1);
    let emulator = Emulator::new(Protocol::Native, BaseSettings::default(), 1);
    pair.emulator = change(emulator.expect("valid settings"));
    pair
}

#[test]
fn wider_machine_turns_less_and_its_gyro_knows() {
    let mut pair = differing(|emulator| emulator.with_width_ratio(1.25));
    pair.drive_for(CURVE, 3.0);
    let feedback = pair.session.latest().expect("feedback").feedback;
    assert!((pair.emulator.twist().angular - 0.24).abs() < 0.02);
    assert!((feedback.twist.angular - 0.3).abs() < 0.03, "{feedback:?}");
    assert!(feedback.yaw_rate.is_some_and(|rate| (rate - 0.24).abs() < 0.02), "{feedback:?}");
}

#[test]
fn slipping_machine_loses_its_share_and_repeats_it_for_a_seed() {
    let travelled_m = |share: f64| {
        let mut pair = differing(|emulator| emulator.with_slip(share));
        pair.drive_for(AHEAD, 20.0);
        pair.emulator.travelled_m()
    };
    let lost = 1.0 - travelled_m(0.1) / travelled_m(0.0);
    assert!((0.06..0.14).contains(&lost), "{lost}");
    assert_eq!(travelled_m(0.1).to_bits(), travelled_m(0.1).to_bits());
}

#[test]
fn machine_stands_below_its_deadband() {
    let mut pair = differing(|emulator| emulator.with_deadband(0.05));
    pair.drive_for(Twist::new(0.04, 0.0), 1.0);
    assert_eq!(pair.emulator.travelled_m(), 0.0);
    pair.drive_for(Twist::new(0.06, 0.0), 1.0);
    assert!(pair.emulator.travelled_m() > 0.03);
}

#[test]
fn stuck_encoder_is_found_as_a_track_that_stands() {
    let mut pair = from(InjectedFault::EncoderStuck);
    pair.drive_for(AHEAD, 3.0);
    let (at_s, cause) = pair.cause.expect("a fault");
    assert!(matches!(cause, StopCause::Stuck { side: Side::Left, .. }), "{cause:?}");
    assert!(at_s < 2.3, "{at_s}");
    assert_eq!(pair.emulator.twist(), Twist::STOP);
}

#[test]
fn biased_gyro_is_found_as_slip() {
    let mut pair = from(InjectedFault::GyroBiased);
    pair.drive_for(AHEAD, 3.0);
    let (at_s, cause) = pair.cause.expect("a fault");
    assert!(matches!(cause, StopCause::Slip { .. }) && at_s < 2.3, "{at_s}: {cause:?}");
}

#[test]
fn low_battery_is_reported() {
    let mut pair = from(InjectedFault::LowBattery);
    pair.drive_for(AHEAD, 1.5);
    assert_eq!(pair.session.latest().expect("feedback").feedback.battery_v, Some(15.0));
}

#[test]
fn base_that_ignores_turns_drives_straight() {
    let mut pair = from(InjectedFault::IgnoredTurns);
    pair.drive_for(CURVE, 2.0);
    let twist = pair.emulator.twist();
    assert!((twist.linear - 0.4).abs() < 0.03 && twist.angular.abs() < 0.02, "{twist:?}");
}

#[test]
fn late_motors_follow_after_their_delay() {
    let mut pair = from(InjectedFault::LateMotors);
    pair.drive_for(Twist::STOP, 2.0);
    pair.drive_for(AHEAD, 0.28);
    assert_eq!(pair.emulator.twist(), Twist::STOP);
    pair.drive_for(AHEAD, 1.0);
    assert!((pair.emulator.twist().linear - 0.4).abs() < 0.03);
    pair.drive_for(Twist::STOP, 0.25);
    assert!(pair.emulator.twist().linear > 0.3, "it still drives");
}

#[test]
fn base_without_power_stands_and_restarts_from_zero() {
    let mut pair = with(InjectedFault::Reboot, 2.0, 3.1);
    pair.drive_for(AHEAD, 2.0);
    let counts = |pair: &Pair| pair.session.latest().expect("feedback").feedback.encoder_counts;
    let before = counts(&pair).expect("counts").left;
    pair.drive_for(AHEAD, 1.0);
    assert_eq!(pair.emulator.twist(), Twist::STOP);
    let commands = pair.emulator.command_stats().commands;
    pair.drive_for(AHEAD, 0.6);
    assert!(pair.emulator.command_stats().commands < commands, "a new controller");
    assert!(counts(&pair).expect("counts").left < before, "{before}");
    // A session that outlasts the restart sees a jump of the counters. The supervisor opens a new one.
    let is_jump =
        matches!(pair.cause, Some((_, StopCause::Fault(faults))) if faults == Faults::ENCODER);
    assert!(is_jump, "{:?}", pair.cause);
}

#[test]
fn cut_line_is_left_to_the_watchdog_of_the_base() {
    let mut pair = from(InjectedFault::LineCut);
    pair.drive_for(AHEAD, 1.0);
    let received_s = pair.session.latest().expect("feedback").received_s;
    pair.drive_for(AHEAD, 1.0);
    assert_eq!(pair.session.latest().expect("feedback").received_s, received_s);
    assert_eq!(pair.emulator.command_stats().watchdog_stops, 1);
    assert_eq!(pair.emulator.twist(), Twist::STOP);
}
