//! Each limit of the safety controller, just below it and just above it.

use inbye::base::{
    BaseSettings, CommandRejected, DriveStatus, Faults, Feedback, OutgoingCommand,
    SafetyController, StopCause, SupervisorSettings, Tilt,
};
use inbye::geometry::Twist;

const PERIOD_S: f64 = 0.02;
const AHEAD: Twist = Twist::new(0.6, 0.0);
const ZERO: OutgoingCommand = OutgoingCommand::Drive(Twist::STOP);

/// A controller whose base follows each command at once.
struct Sender {
    controller: SafetyController,
    now_s: f64,
    base: Twist,
}

impl Sender {
    fn standing() -> Self {
        let settings = SupervisorSettings::default();
        let controller = SafetyController::new(&BaseSettings::default(), settings);
        let mut sender =
            Self { controller: controller.expect("valid"), now_s: 100.0, base: Twist::STOP };
        sender.cycles(1.0);
        sender
    }

    fn driving() -> Self {
        let mut sender = Self::standing();
        for _ in 0..50 {
            sender.set_target(0.0).expect("a valid target");
            sender.cycle(PERIOD_S);
        }
        assert_eq!(sender.base, AHEAD);
        sender
    }

    /// Sets a target with a stamp of this age, seconds.
    fn set_target(&mut self, age_s: f64) -> Result<(), CommandRejected> {
        self.controller.set_target(&AHEAD, self.now_s - age_s, self.now_s)
    }

    fn report(&mut self, feedback: Feedback) {
        self.controller.on_feedback(&feedback, self.now_s);
    }

    fn next(&mut self, elapsed_s: f64) -> OutgoingCommand {
        self.now_s += elapsed_s;
        self.controller.next_command(self.now_s)
    }

    fn cycle(&mut self, elapsed_s: f64) -> OutgoingCommand {
        let command = self.next(elapsed_s);
        self.base = match command {
            OutgoingCommand::Drive(twist) => twist,
            OutgoingCommand::EngageStop | OutgoingCommand::ReleaseStop => Twist::STOP,
        };
        self.report(Feedback { twist: self.base, ..Feedback::default() });
        command
    }

    fn cycles(&mut self, time_s: f64) {
        (0..(time_s / PERIOD_S).round() as u32).for_each(|_| _ = self.cycle(PERIOD_S));
    }

    fn status(&self) -> &DriveStatus {
        self.controller.status()
    }
}

/// A gap is longer than 0.2 s and a period.
#[test]
fn pause_above_the_longest_gap_and_backward_clock_command_zero() {
    for (elapsed_s, is_gap) in [(0.21, false), (0.23, true), (-0.01, true), (-5.0, true)] {
        let mut sender = Sender::driving();
        // The next target is fresh: only the gap can stop the base.
        let stamp_s = sender.now_s + elapsed_s;
        sender.now_s = stamp_s.max(sender.now_s);
        let newest_s = sender.now_s;
        let target = sender.controller.set_target(&AHEAD, newest_s, newest_s);
        assert_eq!(target, Ok(()));
        let command = sender.controller.next_command(stamp_s);
        assert_eq!(command == ZERO, is_gap, "{elapsed_s} s: {command:?}");
    }
}

#[test]
fn report_older_than_the_longest_gap_brakes() {
    for (age_s, is_late) in [(0.21, false), (0.23, true)] {
        let mut sender = Sender::driving();
        sender.set_target(0.0).expect("a valid target");
        sender.report(Feedback { twist: AHEAD, age_s, ..Feedback::default() });
        let command = sender.next(PERIOD_S);
        let is_found = matches!(sender.status(), DriveStatus::ReportsLate { .. });
        assert_eq!(is_found, is_late, "{age_s} s: {command:?}");
        assert_eq!(command == OutgoingCommand::Drive(AHEAD), !is_late, "{age_s} s");
    }
}

/// A base whose reports were late restarts like any other: zeros for 0.1 s, and only for a newer target.
#[test]
fn target_from_before_late_reports_is_not_followed() {
    let mut sender = Sender::driving();
    let late = Feedback { twist: Twist::STOP, age_s: 0.3, ..Feedback::default() };
    sender.report(late);
    sender.set_target(0.0).expect("a valid target");
    let _ = sender.next(PERIOD_S);
    sender.report(Feedback::default());
    for _ in 0..12 {
        // 0.24 s: the target from before has not yet expired.
        assert_eq!(sender.next(PERIOD_S), ZERO);
        sender.report(Feedback::default());
    }
    assert_eq!(*sender.status(), DriveStatus::Restarting);
}

#[test]
fn zeros_after_a_gap_last_a_tenth_of_a_second() {
    let mut sender = Sender::driving();
    sender.now_s += 1.0;
    assert_eq!(sender.cycle(PERIOD_S), ZERO);
    let ended_s = sender.now_s;
    let first_s = loop {
        sender.set_target(0.0).expect("a valid target");
        if sender.cycle(PERIOD_S) != ZERO {
            break sender.now_s;
        }
    };
    assert!((0.099..0.121).contains(&(first_s - ended_s)), "{} s", first_s - ended_s);
}

#[test]
fn target_expires_at_its_timeout_and_one_from_a_later_clock_too() {
    for (age_s, is_valid) in [(0.29, true), (0.31, false)] {
        let mut sender = Sender::driving();
        sender.set_target(0.0).expect("a valid target");
        sender.cycles(0.26);
        sender.cycle(age_s - 0.26);
        assert_eq!(*sender.status() == DriveStatus::Driving, is_valid, "{:?}", sender.status());
    }
    // The clock ran backwards after the target was set.
    let mut sender = Sender::driving();
    sender.set_target(0.0).expect("a valid target");
    sender.now_s -= 1.0;
    sender.cycles(0.3);
    assert!(matches!(sender.status(), DriveStatus::TargetExpired { age_s } if *age_s < -0.3));
    assert_eq!(sender.base, Twist::STOP);
}

#[test]
fn target_is_at_most_its_timeout_ahead() {
    let mut sender = Sender::standing();
    assert!(matches!(sender.set_target(-0.31), Err(CommandRejected::TooFarAhead { .. })));
    assert_eq!(sender.set_target(-0.29), Ok(()));
}

/// From a base that stands although 0.6 m/s were sent: a lag of 0.2 s at 1.5 m/s^2 permits 0.3 m/s, less a period of braking.
#[test]
fn braking_starts_at_most_a_lag_above_the_measured_speed() {
    let mut sender = Sender::driving();
    sender.controller.set_target(&Twist::STOP, sender.now_s, sender.now_s).expect("valid");
    sender.report(Feedback::default());
    let OutgoingCommand::Drive(first) = sender.next(PERIOD_S) else { panic!("a motion") };
    assert!((first.linear - 0.27).abs() < 1e-6, "{first:?}");
}

/// A cycle that was late by 0.18 s accelerates as one of 0.1 s.
#[test]
fn late_cycle_ramps_by_a_tenth_of_a_second() {
    let mut sender = Sender::standing();
    for _ in 0..8 {
        sender.set_target(0.0).expect("a valid target");
        sender.cycle(PERIOD_S);
    }
    let before = sender.base.linear;
    assert!((0.0..0.3).contains(&before), "{before}");
    sender.set_target(0.0).expect("a valid target");
    sender.cycle(0.2);
    assert!((sender.base.linear - before - 0.15).abs() < 1e-6, "{before} {:?}", sender.base);
}

#[test]
fn emergency_stop_counts_half_a_second_after_a_release() {
    for (time_s, stops) in [(0.46, false), (0.54, true)] {
        let mut sender = Sender::standing();
        sender.controller.stop(StopCause::Requested);
        sender.cycles(0.4);
        sender.controller.release().expect("it stands");
        assert_eq!(sender.next(PERIOD_S), OutgoingCommand::ReleaseStop);
        let released_s = sender.now_s;
        let pressed = Feedback { emergency_stop: true, ..Feedback::default() };
        while sender.now_s - released_s < time_s - 1e-9 {
            sender.report(pressed);
            sender.next(PERIOD_S);
        }
        assert_eq!(sender.controller.stop_cause().is_some(), stops, "{time_s} s");
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
        let mut sender = Sender::standing();
        sender.controller.stop(StopCause::Requested);
        for _ in 0..40 {
            sender.next(PERIOD_S);
            sender.report(report);
        }
        let released = sender.controller.release();
        assert_eq!(released.is_ok(), stands, "{report:?}");
    }
    for (time_s, stands) in [(0.28, false), (0.32, true)] {
        let mut sender = Sender::standing();
        sender.controller.stop(StopCause::Requested);
        sender.report(moving(0.5, 0.0));
        sender.next(PERIOD_S);
        sender.report(Feedback::default());
        sender.cycles(time_s);
        assert_eq!(sender.controller.release().is_ok(), stands, "{time_s} s");
    }
}

#[test]
fn first_cause_of_a_stop_is_kept() {
    let mut sender = Sender::driving();
    sender.controller.stop(StopCause::Requested);
    sender.controller.stop(StopCause::Cliff);
    assert_eq!(sender.controller.stop_cause(), Some(&StopCause::Requested));
    let late = Feedback { faults: Faults::OVERHEATED, ..Feedback::default() };
    sender.report(late);
    assert_eq!(sender.controller.stop_cause(), Some(&StopCause::Requested));
}

/// A base that rolls against the target restarts from its measured speed, and not from zero or the opposite one.
#[test]
fn restart_ramps_from_the_measured_speed_with_its_sign() {
    let mut sender = Sender::driving();
    sender.now_s += 1.0;
    let rolls = Feedback { twist: Twist::new(0.4, 0.0), ..Feedback::default() };
    sender.report(rolls);
    let first = loop {
        let command = sender.next(PERIOD_S);
        sender.set_target(0.0).expect("a valid target");
        sender.report(rolls);
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
        let mut sender = Sender::standing();
        for _ in 0..12 {
            sender.next(PERIOD_S);
            sender.report(Feedback { tilt: Some(Tilt { roll, pitch }), ..Feedback::default() });
        }
        assert_eq!(sender.controller.stop_cause().is_some(), stops, "{roll} {pitch}");
    }
}

/// A good track width is known to some percent: 2 rad/s by the tracks may be 1.5 rad/s on the ground.
#[test]
fn fast_turn_with_a_fourth_of_slip_is_no_fault() {
    for (gyro, stops) in [(1.5, false), (0.9, true)] {
        let mut sender = Sender::standing();
        let twist = Twist::new(0.0, 2.0);
        for _ in 0..100 {
            sender.controller.set_target(&twist, sender.now_s, sender.now_s).ok();
            let OutgoingCommand::Drive(sent) = sender.next(PERIOD_S) else { break };
            let yaw_rate = Some(sent.angular * gyro / 2.0);
            sender.report(Feedback { twist: sent, yaw_rate, ..Feedback::default() });
        }
        let cause = sender.controller.stop_cause();
        assert_eq!(matches!(cause, Some(StopCause::Slip { .. })), stops, "{gyro} {cause:?}");
    }
}
