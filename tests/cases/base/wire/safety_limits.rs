//! Each limit of the safety controller, just below it and just above it.

use inbye::base::{
    CommandRejected, DriveStatus, Faults, Feedback, OutgoingCommand, StopCause, Tilt,
};
use inbye::geometry::Twist;

use super::harness::{AHEAD, Harness};

const ZERO: OutgoingCommand = OutgoingCommand::Drive(Twist::STOP);

/// A gap is longer than 0.2 s and a period.
#[test]
fn pause_above_the_longest_gap_and_backward_clock_command_zero() {
    for (elapsed_s, is_gap) in [(0.21, false), (0.23, true), (-0.01, true), (-5.0, true)] {
        let mut harness = Harness::driving();
        // The next target is fresh: only the gap can stop the base.
        let stamp_s = harness.now_s + elapsed_s;
        harness.now_s = stamp_s.max(harness.now_s);
        let newest_s = harness.now_s;
        let target = harness.controller.set_target(&AHEAD, newest_s, newest_s);
        assert_eq!(target, Ok(()));
        let command = harness.controller.next_command(stamp_s);
        assert_eq!(command == ZERO, is_gap, "{elapsed_s} s: {command:?}");
    }
}

#[test]
fn report_older_than_the_longest_gap_brakes() {
    for (age_s, is_late) in [(0.21, false), (0.23, true)] {
        let mut harness = Harness::driving();
        harness.set_target(0.0).expect("a valid target");
        harness.on_feedback(Feedback { twist: AHEAD, age_s, ..Feedback::default() });
        let command = harness.next_command();
        let is_found = matches!(harness.status(), DriveStatus::ReportsLate { .. });
        assert_eq!(is_found, is_late, "{age_s} s: {command:?}");
        assert_eq!(command == OutgoingCommand::Drive(AHEAD), !is_late, "{age_s} s");
    }
}

/// A base whose reports were late restarts like any other: zeros for 0.1 s, and only for a newer target.
#[test]
fn target_from_before_late_reports_is_not_followed() {
    let mut harness = Harness::driving();
    let late = Feedback { twist: Twist::STOP, age_s: 0.3, ..Feedback::default() };
    harness.on_feedback(late);
    harness.set_target(0.0).expect("a valid target");
    let _ = harness.next_command();
    harness.on_feedback(Feedback::default());
    for _ in 0..12 {
        // 0.24 s: the target from before has not yet expired.
        assert_eq!(harness.next_command(), ZERO);
        harness.on_feedback(Feedback::default());
    }
    assert_eq!(*harness.status(), DriveStatus::Restarting);
}

#[test]
fn zeros_after_a_gap_last_a_tenth_of_a_second() {
    let mut harness = Harness::driving();
    harness.now_s += 1.0;
    assert_eq!(harness.cycle(), ZERO);
    let ended_s = harness.now_s;
    let first_s = loop {
        harness.set_target(0.0).expect("a valid target");
        if harness.cycle() != ZERO {
            break harness.now_s;
        }
    };
    assert!((0.099..0.121).contains(&(first_s - ended_s)), "{} s", first_s - ended_s);
}

#[test]
fn target_expires_at_its_timeout_and_one_from_a_later_clock_too() {
    for (age_s, is_valid) in [(0.29, true), (0.31, false)] {
        let mut harness = Harness::driving();
        harness.set_target(0.0).expect("a valid target");
        harness.cycles(0.26);
        harness.cycle_after(age_s - 0.26);
        assert_eq!(*harness.status() == DriveStatus::Driving, is_valid, "{:?}", harness.status());
    }
    // The clock ran backwards after the target was set.
    let mut harness = Harness::driving();
    harness.set_target(0.0).expect("a valid target");
    harness.now_s -= 1.0;
    harness.cycles(0.3);
    assert!(matches!(harness.status(), DriveStatus::TargetExpired { age_s } if *age_s < -0.3));
    assert_eq!(harness.base, Twist::STOP);
}

#[test]
fn target_is_at_most_its_timeout_ahead() {
    let mut harness = Harness::standing();
    assert!(matches!(harness.set_target(-0.31), Err(CommandRejected::TooFarAhead { .. })));
    assert_eq!(harness.set_target(-0.29), Ok(()));
}

/// From a base that stands although 0.6 m/s were sent: a lag of 0.2 s at 1.5 m/s^2 permits 0.3 m/s, less a period of braking.
#[test]
fn braking_starts_at_most_a_lag_above_the_measured_speed() {
    let mut harness = Harness::driving();
    harness.controller.set_target(&Twist::STOP, harness.now_s, harness.now_s).expect("valid");
    harness.on_feedback(Feedback::default());
    let OutgoingCommand::Drive(first) = harness.next_command() else { panic!("a motion") };
    assert!((first.linear - 0.27).abs() < 1e-6, "{first:?}");
}

/// A cycle that was late by 0.18 s accelerates as a punctual one, and brakes for the whole time.
#[test]
fn late_cycle_accelerates_for_one_period_and_brakes_for_its_whole_time() {
    let mut harness = Harness::standing();
    for _ in 0..8 {
        harness.set_target(0.0).expect("a valid target");
        harness.cycle();
    }
    let before = harness.base.linear;
    assert!((0.0..0.3).contains(&before), "{before}");
    harness.set_target(0.0).expect("a valid target");
    harness.cycle_after(0.2);
    assert!((harness.base.linear - before - 0.03).abs() < 1e-6, "{before} {:?}", harness.base);
    let mut harness = Harness::driving();
    harness.controller.set_target(&Twist::STOP, harness.now_s, harness.now_s).expect("valid");
    harness.cycle_after(0.2);
    assert!((harness.base.linear - (0.6 - 1.5 * 0.2)).abs() < 1e-6, "{:?}", harness.base);
}

#[test]
fn emergency_stop_counts_half_a_second_after_a_release() {
    for (time_s, stops) in [(0.46, false), (0.54, true)] {
        let mut harness = Harness::standing();
        harness.controller.stop(StopCause::Requested);
        harness.cycles(0.4);
        harness.controller.release().expect("it stands");
        assert_eq!(harness.next_command(), OutgoingCommand::ReleaseStop);
        let released_s = harness.now_s;
        let pressed = Feedback { emergency_stop: true, ..Feedback::default() };
        while harness.now_s - released_s < time_s - 1e-9 {
            harness.on_feedback(pressed);
            harness.next_command();
        }
        assert_eq!(harness.controller.stop_cause().is_some(), stops, "{time_s} s");
    }
}

#[test]
fn base_stands_by_both_tracks_and_the_gyro_for_a_third_of_a_second() {
    let turning = |rate| Feedback { yaw_rate: Some(rate), ..Feedback::default() };
    let moving =
        |linear, angular| Feedback { twist: Twist::new(linear, angular), ..Feedback::default() };
    // The tracks are 0.25 m or more from the middle: a turn of 0.4 rad/s moves each by 0.1 m/s and more.
    for (report, stands) in [
        (turning(0.09), true),
        (turning(0.11), false),
        (turning(-0.3), false),
        (moving(0.09, 0.0), true),
        (moving(0.11, 0.0), false),
        (moving(-0.2, 0.0), false),
        (Feedback { yaw_rate: Some(0.0), ..moving(0.06, 0.3) }, false),
        (Feedback { yaw_rate: Some(0.0), ..moving(0.06, -0.3) }, false),
    ] {
        let mut harness = Harness::standing();
        harness.controller.stop(StopCause::Requested);
        for _ in 0..40 {
            harness.next_command();
            harness.on_feedback(report);
        }
        let released = harness.controller.release();
        assert_eq!(released.is_ok(), stands, "{report:?}");
    }
    for (time_s, stands) in [(0.28, false), (0.32, true)] {
        let mut harness = Harness::standing();
        harness.controller.stop(StopCause::Requested);
        harness.on_feedback(moving(0.5, 0.0));
        harness.next_command();
        harness.on_feedback(Feedback::default());
        harness.cycles(time_s);
        assert_eq!(harness.controller.release().is_ok(), stands, "{time_s} s");
    }
}

#[test]
fn first_cause_of_a_stop_is_kept() {
    let mut harness = Harness::driving();
    harness.controller.stop(StopCause::Requested);
    harness.controller.stop(StopCause::Cliff);
    assert_eq!(harness.controller.stop_cause(), Some(&StopCause::Requested));
    let late = Feedback { faults: Faults::OVERHEATED, ..Feedback::default() };
    harness.on_feedback(late);
    assert_eq!(harness.controller.stop_cause(), Some(&StopCause::Requested));
}

/// A base that rolls against the target restarts from its measured speed, and not from zero or the opposite one.
#[test]
fn restart_ramps_from_the_measured_speed_with_its_sign() {
    let mut harness = Harness::driving();
    harness.now_s += 1.0;
    let rolls = Feedback { twist: Twist::new(0.4, 0.0), ..Feedback::default() };
    harness.on_feedback(rolls);
    let first = loop {
        let command = harness.next_command();
        harness.set_target(0.0).expect("a valid target");
        harness.on_feedback(rolls);
        if command != ZERO {
            break command;
        }
    };
    let OutgoingCommand::Drive(first) = first else { panic!("{first:?}") };
    assert!((first.linear - 0.43).abs() < 1e-6, "{first:?}");
}

#[test]
fn tilt_latches_a_stop_from_its_limit_about_each_axis() {
    for (roll, pitch, stops) in [
        (0.0, 0.34, false),
        (0.0, 0.36, true),
        (0.0, -0.36, true),
        (0.36, 0.0, true),
        (-0.36, 0.0, true),
        (0.34, -0.34, false),
    ] {
        let mut harness = Harness::standing();
        for _ in 0..12 {
            harness.next_command();
            harness
                .on_feedback(Feedback { tilt: Some(Tilt { roll, pitch }), ..Feedback::default() });
        }
        assert_eq!(harness.controller.stop_cause().is_some(), stops, "{roll} {pitch}");
    }
}

/// A good track width is known to some percent: 2 rad/s by the tracks may be 1.5 rad/s on the ground.
#[test]
fn fast_turn_with_a_fourth_of_slip_is_no_fault() {
    for (gyro, stops) in [(1.5, false), (0.9, true)] {
        let mut harness = Harness::standing();
        let twist = Twist::new(0.0, 2.0);
        for _ in 0..100 {
            harness.controller.set_target(&twist, harness.now_s, harness.now_s).ok();
            let OutgoingCommand::Drive(sent) = harness.next_command() else { break };
            let yaw_rate = Some(sent.angular * gyro / 2.0);
            harness.on_feedback(Feedback { twist: sent, yaw_rate, ..Feedback::default() });
        }
        let cause = harness.controller.stop_cause();
        assert_eq!(matches!(cause, Some(StopCause::Slip { .. })), stops, "{gyro} {cause:?}");
    }
}

/// A base whose motors are 0.3 s late has not moved yet. Its reports from before the end show nothing.
#[test]
fn end_waits_for_reports_of_a_standstill_after_the_last_motion() {
    let mut harness = Harness::standing();
    harness.follows = false;
    for _ in 0..14 {
        harness.set_target(0.0).expect("a valid target");
        harness.cycle();
    }
    assert!(harness.speed() > 0.3);
    harness.controller.end(harness.now_s);
    assert!(!harness.controller.has_ended(harness.now_s));
    harness.report.twist = Twist::new(0.3, 0.0);
    harness.cycles(0.2);
    harness.report.twist = Twist::STOP;
    harness.cycles(0.3);
    assert!(!harness.controller.has_ended(harness.now_s));
    harness.cycles(0.04);
    assert!(harness.controller.has_ended(harness.now_s));
    assert_eq!(harness.controller.stop_cause(), None);
}

#[test]
fn report_that_comes_again_shows_no_standstill() {
    let mut harness = Harness::driving();
    harness.controller.end(harness.now_s);
    harness.next_command();
    let reported_s = harness.now_s;
    // Until the time for braking and settling is over.
    for _ in 0..60 {
        let age_s = harness.now_s - reported_s;
        harness.on_feedback(Feedback { age_s, ..Feedback::default() });
        assert!(!harness.controller.has_ended(harness.now_s), "{age_s} s");
        harness.next_command();
    }
}

#[test]
fn supervisor_of_a_base_that_reports_no_finite_motion_ends() {
    for linear in [f64::NAN, f64::INFINITY, 1e30] {
        for is_ending in [false, true] {
            let mut harness = Harness::driving();
            let ends = |harness: &mut Harness| harness.controller.end(harness.now_s);
            if is_ending {
                ends(&mut harness);
            }
            let twist = Twist::new(linear, 0.0);
            harness.on_feedback(Feedback { twist, ..Feedback::default() });
            if !is_ending {
                ends(&mut harness);
            }
            // Braking from the highest plausible speed, 1.9 m/s at 1.5 m/s^2, and a second.
            assert!(!harness.controller.has_ended(harness.now_s + 1.0));
            assert!(harness.controller.has_ended(harness.now_s + 2.3), "{linear}");
            let cause = harness.controller.stop_cause().expect("a cause").to_string();
            assert!(linear.is_finite() || cause.contains("not finite"), "{linear}: {cause}");
        }
    }
}

/// A requested stop is no fault, and does not tell that the base still moves.
#[test]
fn end_of_a_base_that_still_moves_keeps_a_known_fault() {
    for (cause, is_kept) in
        [(StopCause::Requested, false), (StopCause::Cliff, true), (StopCause::NotFinite, true)]
    {
        let mut harness = Harness::driving();
        harness.controller.stop(cause);
        harness.controller.end(harness.now_s);
        harness.on_feedback(Feedback { twist: AHEAD, ..Feedback::default() });
        assert!(harness.controller.has_ended(harness.now_s + 10.0));
        let found = harness.controller.stop_cause().copied();
        assert_eq!(found == Some(cause), is_kept, "{cause:?}: {found:?}");
        let ignores = matches!(found, Some(StopCause::IgnoresCommands { .. }));
        assert_eq!(ignores, !is_kept, "{cause:?}: {found:?}");
    }
}
