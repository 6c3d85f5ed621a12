//! Restarts after a pause of the process, of the reports or of the base.

use inbye::base::{DriveStatus, Faults, Feedback, OutgoingCommand};
use inbye::geometry::Twist;

use super::{AHEAD, Harness};

/// Speeds of the cycles in a time while a target is renewed ten times per second.
fn speeds_while_driving(harness: &mut Harness, time_s: f64) -> Vec<f64> {
    let before = harness.commands.len();
    harness.drive(AHEAD, time_s);
    let speed = |command: &OutgoingCommand| match command {
        OutgoingCommand::Drive(twist) => twist.linear,
        other => panic!("{other:?}"),
    };
    harness.commands[before..].iter().map(speed).collect()
}

/// Checks that zeros go for 0.1 s, and then a ramp from the base's measured speed.
#[track_caller]
fn assert_restarts_from(speeds: &[f64], measured: f64) {
    assert!(speeds[..4].iter().all(|speed| *speed == 0.0), "{speeds:?}");
    let first = speeds.iter().find(|speed| **speed != 0.0).expect("it drives again");
    assert!(*first <= measured + 0.0301 && *first > measured, "{speeds:?}");
    assert_eq!(speeds.last(), Some(&0.6), "{speeds:?}");
}

/// The base follows commands again: it restarts from zero.
#[track_caller]
fn assert_restarts_from_standstill(harness: &mut Harness) {
    harness.follows = true;
    assert_restarts_from(&speeds_while_driving(harness, 1.0), 0.0);
}

/// The process was stopped for 2 s. The watchdog has stopped the base meanwhile.
#[test]
fn base_stands_after_pause_of_process_and_restarts_for_newer_target() {
    let mut harness = Harness::new();
    harness.drive(AHEAD, 1.0);
    harness.now_s += 2.0;
    // The planner decides before the sender's next cycle: from an observation made before the pause was noticed.
    let stamp_s = harness.now_s;
    harness.controller.set_target(&AHEAD, stamp_s, stamp_s).expect("a valid target");
    harness.report.twist = Twist::STOP;
    for _ in 0..10 {
        assert_eq!(harness.cycle(), OutgoingCommand::Drive(Twist::STOP));
    }
    assert_eq!(*harness.controller.status(), DriveStatus::Restarting);
    assert!(harness.controller.resumed_s() > stamp_s);
    assert_restarts_from(&[vec![0.0; 4], speeds_while_driving(&mut harness, 1.0)].concat(), 0.0);
}

#[test]
fn base_that_drove_on_during_pause_restarts_from_its_measured_speed() {
    let mut harness = Harness::new();
    harness.drive(AHEAD, 1.0);
    harness.now_s += 2.0;
    harness.follows = false;
    harness.report.twist = Twist::new(0.4, 0.0);
    harness.cycle();
    let speeds = speeds_while_driving(&mut harness, 0.4);
    assert_restarts_from(&speeds, 0.4);
}

#[test]
fn late_cycle_within_the_longest_gap_does_not_interrupt() {
    let mut harness = Harness::new();
    harness.drive(AHEAD, 1.0);
    harness.now_s += 0.15;
    harness.cycle();
    assert!(harness.speed() > 0.44, "{}", harness.speed());
}

#[test]
fn late_reports_brake_base_and_restart_it() {
    let mut harness = Harness::new();
    harness.drive(AHEAD, 1.0);
    for cycle in 0..40 {
        let now_s = harness.now_s;
        harness.controller.set_target(&AHEAD, now_s, now_s).expect("a valid target");
        harness.next_command();
        let age_s = 0.02 * f64::from(cycle);
        let report = Feedback { twist: AHEAD, age_s, ..Feedback::default() };
        harness.controller.on_feedback(&report, harness.now_s);
        if age_s < 0.2 {
            assert_eq!(harness.speed(), 0.6);
        }
    }
    assert_eq!(harness.speed(), 0.0, "0.22 s and 0.4 s to brake");
    assert!(matches!(harness.controller.status(), DriveStatus::ReportsLate { .. }));
    harness.report.twist = Twist::STOP;
    harness.follows = false;
    harness.cycle();
    assert_restarts_from_standstill(&mut harness);
}

/// The line lost the host's commands, and the base has stopped by itself.
#[test]
fn base_stopped_by_its_watchdog_restarts_from_zero() {
    let mut harness = Harness::new();
    harness.drive(AHEAD, 1.0);
    harness.report.faults = Faults::WATCHDOG;
    harness.follows = false;
    harness.cycle();
    harness.report.faults = Faults::NONE;
    assert_restarts_from_standstill(&mut harness);
}

#[test]
fn suspected_stop_commands_zero_without_a_latch() {
    let mut harness = Harness::new();
    harness.drive(AHEAD, 1.0);
    harness.report.is_stop_suspected = true;
    harness.cycle();
    harness.report.is_stop_suspected = false;
    let speeds = speeds_while_driving(&mut harness, 1.0);
    assert_restarts_from(&speeds, 0.0);
    assert_eq!(harness.controller.stop_cause(), None);
}
