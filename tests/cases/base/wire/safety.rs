//! The safety controller with a simulated clock.

mod restarts;

use inbye::base::{
    BaseError, Bumper, CollisionMonitorSettings, CommandRejected, DriveStatus, Faults, Feedback,
    OperatorSwitch, OutgoingCommand, ProtectiveAction, ProtectiveLayer, StopCause, Tilt,
};
use inbye::geometry::Twist;
use inbye::robot::{Footprint, Limits};

use super::harness::{AHEAD, Harness, PERIOD_S};

#[test]
fn target_is_ramped_up_and_followed() {
    let mut harness = Harness::new();
    assert_eq!(*harness.controller.status(), DriveStatus::AwaitingFeedback);
    harness.cycle();
    assert_eq!(*harness.controller.status(), DriveStatus::NoTarget);
    harness.drive(AHEAD, 1.0);
    assert_eq!(*harness.controller.status(), DriveStatus::Driving);
    assert_eq!(harness.speed(), 0.6);
    let speeds: Vec<f64> = harness
        .commands
        .iter()
        .map(|command| match command {
            OutgoingCommand::Drive(twist) => twist.linear,
            other => panic!("{other:?}"),
        })
        .collect();
    // 1.5 m/s^2.
    assert!(speeds.windows(2).all(|pair| pair[1] - pair[0] < 0.0301));
}

/// The time stamp of the target counts, not the activity of the planner's thread.
#[test]
fn expired_target_brakes_even_if_repeated() {
    let mut harness = Harness::new();
    harness.drive(AHEAD, 1.0);
    let stuck_s = harness.now_s;
    let mut stopped_after_s = None;
    for _ in 0..100 {
        // A hung planner repeats the same target.
        let _ = harness.controller.set_target(&AHEAD, stuck_s - 0.1, harness.now_s);
        harness.cycle();
        if harness.speed() == 0.0 {
            stopped_after_s = stopped_after_s.or(Some(harness.now_s - stuck_s));
        }
    }
    // 0.2 s until it expires, and 0.4 s to brake from 0.6 m/s at 1.5 m/s^2.
    let stopped_after_s = stopped_after_s.expect("it stopped");
    assert!((0.55..0.67).contains(&stopped_after_s), "{stopped_after_s}");
    assert!(matches!(
        harness.controller.status(),
        DriveStatus::TargetExpired { age_s } if *age_s > 1.0
    ));
    harness.drive(AHEAD, 1.0);
    assert_eq!(harness.speed(), 0.6, "a new target is followed again");
}

#[test]
fn invalid_targets_are_rejected_and_counted() {
    let mut harness = Harness::new();
    harness.drive(AHEAD, 1.0);
    let now_s = harness.now_s;
    let mut set_target = |twist, stamp_s| harness.controller.set_target(&twist, stamp_s, now_s);
    let bad = Twist::new(f64::NAN, 0.0);
    assert_eq!(set_target(bad, now_s), Err(CommandRejected::NotFinite));
    assert_eq!(set_target(Twist::new(0.0, f64::INFINITY), now_s), Err(CommandRejected::NotFinite));
    assert_eq!(set_target(Twist::STOP, f64::NAN), Err(CommandRejected::NotFinite));
    assert!(matches!(
        set_target(Twist::STOP, now_s - 0.5),
        Err(CommandRejected::OutOfOrder { .. })
    ));
    assert!(matches!(
        set_target(Twist::STOP, now_s + 0.4),
        Err(CommandRejected::TooFarAhead { .. })
    ));
    assert_eq!(harness.controller.rejected(), 5);
    harness.cycle();
    assert_eq!(harness.speed(), 0.6);
}

#[test]
fn backward_clock_stops_base() {
    let mut harness = Harness::new();
    harness.drive(AHEAD, 1.0);
    harness.now_s = 3.0;
    harness.cycles(1.0);
    assert_eq!(harness.speed(), 0.0);
}

/// A base that has not followed its command brakes from where it is.
#[test]
fn expired_target_brakes_from_measured_speed_with_lag_allowance() {
    let mut harness = Harness::new();
    harness.drive(AHEAD, 0.4);
    assert!(harness.speed() > 0.4);
    harness.follows = false;
    harness.report.twist = Twist::STOP;
    // Until the target expires.
    harness.cycles(0.24);
    assert!(harness.speed() <= 0.3, "{}", harness.speed());
    harness.cycles(0.2);
    assert_eq!(harness.speed(), 0.0);
}

#[test]
fn bumper_cliff_and_tilt_latch_a_stop() {
    let pressed = Bumper { left: false, right: true };
    let tilt = Some(Tilt { roll: -0.5, pitch: 0.0 });
    let reports = [
        (Feedback { bumper: pressed, ..Feedback::default() }, 1, "the right bumper is pressed"),
        (Feedback { cliff: true, ..Feedback::default() }, 1, "a cliff sensor sees no ground"),
        (Feedback { tilt, ..Feedback::default() }, 12, "the base is tilted (roll -0.50 rad"),
    ];
    for (report, cycles, words) in reports {
        let mut harness = Harness::new();
        harness.drive(AHEAD, 1.0);
        harness.report = report;
        for _ in 0..cycles {
            harness.cycle();
        }
        let cause = harness.controller.stop_cause().expect("a stop").to_string();
        assert!(cause.starts_with(words), "{cause}");
        assert_eq!(harness.cycle(), OutgoingCommand::EngageStop);
    }
    let mut harness = Harness::new();
    harness.report.tilt = Some(Tilt { roll: 0.3, pitch: -0.3 });
    harness.drive(AHEAD, 1.0);
    assert_eq!(harness.controller.stop_cause(), None);
}

#[test]
fn stop_is_latched_until_release_and_new_target() {
    let mut harness = Harness::new();
    harness.drive(AHEAD, 1.0);
    harness.controller.stop(StopCause::Requested);
    assert_eq!(harness.cycle(), OutgoingCommand::EngageStop);
    let now_s = harness.now_s;
    assert_eq!(harness.controller.set_target(&AHEAD, now_s, now_s), Err(CommandRejected::Stopped));
    harness.cycles(5.0);
    assert_eq!(harness.controller.stop_cause(), Some(&StopCause::Requested));
    assert!(
        harness.commands[harness.commands.len() - 200..]
            .iter()
            .all(|command| *command == OutgoingCommand::EngageStop)
    );
    harness.controller.release().expect("it stands");
    assert_eq!(harness.cycle(), OutgoingCommand::ReleaseStop);
    harness.cycles(1.0);
    assert_eq!(harness.cycle(), OutgoingCommand::Drive(Twist::STOP));
    harness.drive(AHEAD, 1.0);
    assert_eq!(harness.speed(), 0.6);
}

#[test]
fn moving_base_is_not_released() {
    let mut harness = Harness::new();
    harness.controller.stop(StopCause::Requested);
    harness.cycle();
    let moving = Feedback { twist: Twist::new(0.3, 0.0), ..Feedback::default() };
    harness.controller.on_feedback(&moving, harness.now_s);
    assert_eq!(harness.controller.release(), Err(CommandRejected::StillMoving));
    assert_eq!(harness.cycle(), OutgoingCommand::EngageStop);
    let reversal = harness.controller.release();
    assert_eq!(reversal, Err(CommandRejected::StillMoving), "a single report of zero");
    harness.cycles(0.4);
    harness.controller.release().expect("it stands now");
}

#[test]
fn detected_fault_latches_stop_with_its_cause() {
    let mut harness = Harness::new();
    harness.follows = false;
    // The base ignores its commands.
    for _ in 0..20 {
        let now_s = harness.now_s;
        let _ = harness.controller.set_target(&AHEAD, now_s, now_s);
        harness.cycles(0.1);
    }
    let cause = harness.controller.stop_cause().expect("a stuck base is stopped");
    assert!(matches!(cause, StopCause::IgnoresCommands { .. }));
    let words = cause.to_string();
    assert!(words.starts_with("the base stands while commanded 0.60 m/s"), "{words}");
    assert_eq!(harness.cycle(), OutgoingCommand::EngageStop);
}

#[test]
fn emergency_stop_may_be_reported_shortly_after_release() {
    let mut harness = Harness::new();
    harness.report.emergency_stop = true;
    harness.cycle();
    let button = StopCause::EmergencyStop;
    assert_eq!(harness.controller.stop_cause(), Some(&button));
    // Released too early: the stop is detected again.
    harness.controller.release().expect("it stands");
    harness.cycles(0.6);
    assert_eq!(harness.controller.stop_cause(), Some(&button));
    // The button is released; the report follows a moment later.
    harness.controller.release().expect("it stands");
    harness.cycles(0.2);
    harness.report.emergency_stop = false;
    harness.cycles(1.0);
    assert_eq!(harness.controller.stop_cause(), None);
    harness.report.emergency_stop = true;
    harness.cycle();
    assert_eq!(harness.controller.stop_cause(), Some(&button));
}

#[test]
fn reported_fault_stops_but_watchdog_does_not() {
    let mut harness = Harness::new();
    harness.report.faults = Faults::WATCHDOG;
    harness.cycles(0.2);
    assert_eq!(harness.controller.stop_cause(), None);
    harness.report.faults = Faults::OVERHEATED;
    harness.cycle();
    let words = harness.controller.stop_cause().expect("a stop").to_string();
    assert_eq!(words, "the base reports: overheated");
}

#[test]
fn new_connection_starts_with_zeros_until_feedback() {
    let mut harness = Harness::new();
    harness.drive(AHEAD, 1.0);
    let error = BaseError::Disconnected { port: "port".to_owned() };
    harness.controller.on_disconnect(error.clone());
    harness.next_command();
    assert_eq!(*harness.controller.status(), DriveStatus::Disconnected(error));
    let reconnect = |harness: &mut Harness| {
        harness.controller.on_connect();
        let now_s = harness.now_s;
        harness.controller.set_target(&AHEAD, now_s, now_s).expect("a valid target");
        harness.next_command()
    };
    assert_eq!(reconnect(&mut harness), OutgoingCommand::Drive(Twist::STOP));
    // Zeros until the first feedback, then a ramp from standstill.
    for _ in 0..5 {
        assert_eq!(harness.next_command(), OutgoingCommand::Drive(Twist::STOP));
    }
    assert_eq!(*harness.controller.status(), DriveStatus::AwaitingFeedback);
    harness.controller.on_feedback(&Feedback::default(), harness.now_s);
    let OutgoingCommand::Drive(first) = harness.next_command() else {
        panic!("no stop was requested");
    };
    assert!(first.linear <= 0.03 + 1e-9, "{first:?}");
}

#[test]
fn latched_stop_survives_reconnection() {
    let mut harness = Harness::new();
    harness.controller.stop(StopCause::Requested);
    harness.controller.on_disconnect(BaseError::Disconnected { port: "port".to_owned() });
    harness.controller.on_connect();
    assert_eq!(harness.cycle(), OutgoingCommand::EngageStop);
    assert_eq!(harness.controller.stop_cause(), Some(&StopCause::Requested));
}

#[test]
fn release_waits_for_a_standstill_on_a_new_connection() {
    let mut harness = Harness::new();
    harness.controller.stop(StopCause::Requested);
    harness.cycles(1.0);
    harness.controller.on_disconnect(BaseError::Disconnected { port: "port".to_owned() });
    harness.controller.release().expect("nothing is reported");
    harness.controller.on_connect();
    assert_eq!(harness.next_command(), OutgoingCommand::Drive(Twist::STOP));
    // The base was pushed meanwhile, and rolls.
    let rolls = Feedback { twist: Twist::new(0.3, 0.0), ..Feedback::default() };
    for _ in 0..50 {
        harness.controller.on_feedback(&rolls, harness.now_s);
        assert_eq!(harness.next_command(), OutgoingCommand::EngageStop);
    }
    harness.cycles(0.2);
    assert!(!harness.commands.contains(&OutgoingCommand::ReleaseStop));
    harness.cycles(0.2);
    assert!(harness.commands.contains(&OutgoingCommand::ReleaseStop));
    harness.drive(AHEAD, 1.0);
    assert_eq!(harness.speed(), 0.6);
}

#[test]
fn standstill_before_a_reconnection_does_not_count() {
    let mut harness = Harness::new();
    harness.cycles(1.0);
    harness.controller.stop(StopCause::Requested);
    harness.controller.on_connect();
    harness.cycle();
    assert_eq!(harness.controller.release(), Err(CommandRejected::StillMoving));
    harness.cycles(0.4);
    harness.controller.release().expect("it stands");
}

/// A base that drives, commanded by hand under the operator's switch.
fn armed() -> (Harness, OperatorSwitch) {
    let mut harness = Harness::new();
    let body = Footprint::round(0.3).expect("a radius");
    let monitor = CollisionMonitorSettings::default();
    let layer = ProtectiveLayer::new(monitor, &body, Limits::default(), PERIOD_S);
    let layer = layer.expect("valid settings").without_lidar();
    let switch = layer.operator();
    harness.controller.protect(layer);
    switch.arm();
    harness.drive(AHEAD, 1.0);
    assert_eq!(harness.speed(), 0.6);
    (harness, switch)
}

/// The switch acts before a missing target and late reports, which only brake.
#[test]
fn operator_stops_a_base_without_a_valid_target_at_once() {
    for is_late in [false, true] {
        for (order, action) in [
            (OperatorSwitch::stop as fn(&OperatorSwitch), ProtectiveAction::OperatorStop),
            (OperatorSwitch::disarm, ProtectiveAction::NotArmed),
        ] {
            let (mut harness, switch) = armed();
            if is_late {
                harness.report.age_s = 0.3;
                harness.cycles(0.04);
                let status = harness.controller.status();
                assert!(matches!(status, DriveStatus::ReportsLate { .. }), "{status:?}");
            } else {
                harness.cycles(0.3);
                let status = harness.controller.status();
                assert!(matches!(status, DriveStatus::TargetExpired { .. }), "{status:?}");
            }
            assert!(harness.speed() > 0.3, "it brakes, {} m/s", harness.speed());
            order(&switch);
            assert_eq!(harness.cycle(), OutgoingCommand::Drive(Twist::STOP));
            assert_eq!(*harness.controller.status(), DriveStatus::Protected(action));
            // Armed again, it stands until there is a new target.
            switch.arm();
            harness.report.age_s = 0.0;
            harness.cycles(0.2);
            assert_eq!(harness.speed(), 0.0);
            harness.drive(AHEAD, 1.0);
            assert_eq!(harness.speed(), 0.6);
        }
    }
}

#[test]
fn repeated_report_keeps_its_time() {
    let mut harness = Harness::new();
    let started_s = harness.now_s;
    assert_eq!(harness.controller.reported_s(), started_s);
    for wobble_s in [3e-6, -4e-6, 8e-6, 0.0] {
        harness.now_s += PERIOD_S;
        let age_s = harness.now_s - started_s + wobble_s;
        let report = Feedback { age_s, ..Feedback::default() };
        harness.controller.on_feedback(&report, harness.now_s);
        assert_eq!(harness.controller.reported_s(), started_s, "{wobble_s}");
    }
    harness.cycle();
    assert_eq!(harness.controller.reported_s(), harness.now_s);
    // A clock that runs backwards.
    harness.now_s -= 50.0;
    harness.cycle();
    assert_eq!(harness.controller.reported_s(), harness.now_s);
}
