//! The fault detector finds each fault in time, and none on a healthy base.

use inbye::base::{
    BaseSample, BaseSettings, FaultDetector, FaultDetectorSettings, Faults, Feedback, StopCause,
};
use inbye::geometry::Twist;
use inbye::robot::{Mixer, PerTrack, Side};

/// Sample period, seconds.
const PERIOD_S: f64 = 0.05;

/// A base with a fault, driven by ramped commands.
struct Drive {
    detector: FaultDetector,
    mixer: Mixer,
    settings: BaseSettings,
    speeds: PerTrack<f64>,
    /// Time constant of the motors, seconds.
    lag_s: f64,
    now_s: f64,
}

impl Drive {
    fn new() -> Self {
        let settings = BaseSettings::default().min_battery_v(Some(22.0));
        Self {
            detector: FaultDetector::new(&settings, FaultDetectorSettings::default())
                .expect("valid settings"),
            mixer: Mixer::new(settings.drive(), settings.tracks),
            settings,
            speeds: PerTrack::both(0.0),
            lag_s: 0.1,
            now_s: 0.0,
        }
    }

    /// Drives for a time. Returns the first fault with the time since the call.
    fn drive_for(
        &mut self,
        target: Twist,
        time_s: f64,
        fault: impl Fn(&mut PerTrack<f64>, &mut Feedback),
    ) -> Option<(f64, StopCause)> {
        let start_s = self.now_s;
        for _ in 0..(time_s / PERIOD_S).round() as usize {
            self.now_s += PERIOD_S;
            let commanded = self.mixer.mix(&target, PERIOD_S);
            let share = 1.0 - libm::exp(-PERIOD_S / self.lag_s);
            self.speeds = self.speeds.zip(commanded, |now, set| now + share * (set - now));
            let mut measured = self.speeds;
            let mut feedback = Feedback { battery_v: Some(24.0), ..Feedback::default() };
            fault(&mut measured, &mut feedback);
            feedback.twist = self.settings.drive().twist(&measured);
            if feedback.yaw_rate.is_none() {
                feedback.yaw_rate = Some(feedback.twist.angular);
            }
            let sample =
                BaseSample { now_s: self.now_s, sent: self.mixer.twist(&commanded), feedback };
            if let Some(cause) = self.detector.update(&sample) {
                return Some((self.now_s - start_s, *cause));
            }
        }
        None
    }
}

fn healthy(_: &mut PerTrack<f64>, _: &mut Feedback) {}

#[test]
fn healthy_base_has_no_fault_in_starts_reversals_and_turns() {
    let mut drive = Drive::new();
    for round in 0..5 {
        for target in [
            Twist::new(1.0, 0.0),
            Twist::new(-1.0, 0.0),
            Twist::new(0.0, 2.0),
            Twist::new(0.0, -2.0),
            Twist::new(0.05, 0.1),
            Twist::new(1.0, 1.0),
            Twist::STOP,
            Twist::new(-0.4, 0.8),
        ] {
            let time_s = [0.3, 0.7, 1.5, 3.0, 6.0][round];
            let cause = drive.drive_for(target, time_s, healthy);
            assert_eq!(cause, None, "{target:?}");
        }
    }
}

#[test]
fn stuck_track_is_found_on_its_side() {
    for side in [Side::Left, Side::Right] {
        let mut drive = Drive::new();
        let stuck = move |measured: &mut PerTrack<f64>, _: &mut Feedback| match side {
            Side::Left => measured.left = 0.002,
            Side::Right => measured.right = 0.002,
        };
        let (after_s, cause) = drive.drive_for(Twist::new(0.5, 0.0), 3.0, stuck).unwrap();
        assert!(matches!(cause, StopCause::Stuck { side: found, .. } if found == side), "{cause}");
        // A ramp to 0.1 m/s, and a second.
        assert!(after_s > 1.0 && after_s < 1.3, "{after_s}");
        let words = format!("the {side} track stands (measured 0.00 m/s) while commanded 0.50 m/s");
        assert!(cause.to_string().starts_with(&words), "{cause}");
    }
}

/// Finding the fault takes a second of commanded motion, however the command is divided.
#[test]
fn stuck_track_is_found_while_command_crosses_zero() {
    let mut drive = Drive::new();
    let stuck = |measured: &mut PerTrack<f64>, _: &mut Feedback| measured.left = 0.0;
    let mut after_s = 0.0;
    let cause = (0..20).find_map(|leg| {
        let speed = if leg % 2 == 0 { 0.5 } else { -0.5 };
        let found = drive.drive_for(Twist::new(speed, 0.0), 0.8, stuck);
        after_s += found.map_or(0.8, |(at_s, _)| at_s);
        found
    });
    assert!(matches!(cause, Some((_, StopCause::Stuck { side: Side::Left, .. }))), "{cause:?}");
    assert!(after_s < 2.0, "{after_s}");
}

#[test]
fn stuck_track_is_found_despite_wrong_samples() {
    let mut drive = Drive::new();
    let sample = std::cell::Cell::new(0);
    let stuck = |measured: &mut PerTrack<f64>, _: &mut Feedback| {
        sample.set(sample.get() + 1);
        measured.left = if sample.get() == 14 { 1.0 } else { 0.0 };
    };
    let (after_s, cause) = drive.drive_for(Twist::new(0.5, 0.0), 3.0, stuck).unwrap();
    assert!(matches!(cause, StopCause::Stuck { side: Side::Left, .. }), "{cause}");
    assert!(after_s < 1.3, "{after_s}");
}

#[test]
fn base_that_ignores_commands_is_found_within_a_second() {
    let mut drive = Drive::new();
    let stands = |measured: &mut PerTrack<f64>, _: &mut Feedback| *measured = PerTrack::both(0.0);
    let (after_s, cause) = drive.drive_for(Twist::new(0.5, 0.0), 3.0, stands).unwrap();
    assert!(matches!(cause, StopCause::IgnoresCommands { .. }), "{cause}");
    assert!(after_s < 1.0, "{after_s}");

    let mut drive = Drive::new();
    assert_eq!(drive.drive_for(Twist::new(0.8, 0.0), 2.0, healthy), None);
    let drives_on =
        |measured: &mut PerTrack<f64>, _: &mut Feedback| *measured = PerTrack::both(0.8);
    let (after_s, cause) = drive.drive_for(Twist::STOP, 3.0, drives_on).unwrap();
    assert!(matches!(cause, StopCause::IgnoresCommands { .. }), "{cause}");
    assert!(after_s <= 1.0, "{after_s}");
}

/// The base was as fast as 0.8 m/s, so that no limit of its motors explains 0.3 m/s.
#[test]
fn base_that_keeps_its_speed_is_found_within_a_second_of_another_command() {
    let keeps = |measured: &mut PerTrack<f64>, _: &mut Feedback| *measured = PerTrack::both(0.3);
    let commands = [
        Twist::new(0.6, 0.0),
        Twist::new(0.45, -0.1),
        Twist::new(0.15, 0.0),
        Twist::new(0.0, 1.0),
        Twist::new(-0.3, 0.0),
    ];
    for command in commands {
        let mut drive = Drive::new();
        assert_eq!(drive.drive_for(Twist::new(0.8, 0.0), 2.0, healthy), None);
        assert_eq!(drive.drive_for(Twist::new(0.3, 0.0), 2.0, healthy), None);
        let (after_s, cause) = drive.drive_for(command, 5.0, keeps).expect("a fault");
        assert!(matches!(cause, StopCause::IgnoresCommands { .. }), "{command:?}: {cause}");
        assert!(after_s <= 1.0, "{command:?}: {after_s}");
        let text = cause.to_string();
        assert!(text.starts_with("the base keeps 0.30 m/s and 0.00 rad/s while"), "{text}");
    }
}

/// Without an earlier faster motion, 0.3 m/s may be all that the motors can do.
#[test]
fn motors_at_their_limit_do_not_ignore_commands() {
    // The limit of the tracks after each command, m/s: of the motors, and then of a slope, also one that begins on the ramp.
    for (limit, uphill) in [(0.31, 0.31), (0.5, 0.5), (1.0, 0.33), (1.0, 0.45), (1.0, 0.6)] {
        for accelerating in [0.2, 0.5, 1.0] {
            let mut drive = Drive::new();
            drive.lag_s = 0.15;
            let tracks = drive.settings.tracks.acc_lim_track(accelerating);
            drive.mixer = Mixer::new(drive.settings.drive(), tracks);
            for (speed, limit) in [
                (0.8, limit),
                (0.3, limit),
                (0.8, uphill),
                (0.7, uphill),
                (0.9, uphill),
                (0.3, uphill),
                (0.0, uphill),
                (0.8, uphill),
                (0.3, limit),
            ] {
                let limited = |measured: &mut PerTrack<f64>, _: &mut Feedback| {
                    *measured = measured.map(|speed| speed.clamp(-limit, limit));
                };
                let cause = drive.drive_for(Twist::new(speed, 0.0), 3.0, limited);
                assert_eq!(cause, None, "{accelerating} m/s^2: {speed} of {limit} m/s");
            }
        }
    }
}

/// A first-order lag of 0.4 s, or commands that arrive 0.4 s late, with weak motors, a deadband and a coasting base.
#[test]
fn sound_base_that_follows_late_or_weakly_does_not_ignore_commands() {
    for (lag_s, delay_s, share, deadband, coasting) in [
        (0.4, 0.0, 1.0, 0.0, 1.0),
        (0.1, 0.4, 1.0, 0.0, 1.0),
        (0.1, 0.0, 0.5, 0.0, 1.0),
        (0.4, 0.0, 0.85, 0.05, 1.0),
        (0.1, 0.1, 1.0, 0.08, 1.0),
        (0.15, 0.1, 1.0, 0.0, 0.5),
    ] {
        let mut drive = Drive::new();
        drive.lag_s = lag_s;
        let late = (delay_s / PERIOD_S).round() as usize;
        let queue = std::cell::RefCell::new(vec![PerTrack::both(0.0); late]);
        let last = std::cell::Cell::new(PerTrack::both(0.0));
        let changed = |measured: &mut PerTrack<f64>, _: &mut Feedback| {
            queue.borrow_mut().push(*measured);
            let arrived = queue.borrow_mut().remove(0);
            let moves = |speed: f64| if speed.abs() < deadband { 0.0 } else { share * speed };
            // A coasting base slows down by this, m/s^2, at most.
            let fastest_s = |speed: f64, before: f64| {
                let least = before.abs() - coasting * PERIOD_S;
                if speed.abs() < least { least * before.signum() } else { speed }
            };
            *measured = arrived.map(moves).zip(last.get(), fastest_s);
            last.set(*measured);
        };
        for leg in 0..400_u32 {
            let draw = |step: u32| f64::from((leg * 7919 + step * 31) % 101) / 100.0;
            // Few and slow turns: with such a lag, a turn that reverses is a fault.
            let target = Twist::new(0.2 + 0.7 * draw(1), 0.2 * draw(2) - 0.1);
            let cause = drive.drive_for(target, 0.1 + 2.9 * draw(3), changed);
            assert_eq!(cause, None, "{lag_s} {delay_s} {share} {coasting}, leg {leg}: {target:?}");
        }
    }
}

/// A lag of 0.15 s, 20 % less on a slope, encoders with 10 mm per tick, and a wrong sample each second.
#[test]
fn sound_base_with_lag_slope_and_coarse_encoders_has_no_fault() {
    for seed in 0..20_u32 {
        let mut drive = Drive::new();
        drive.lag_s = 0.15;
        let travel_m = std::cell::Cell::new(PerTrack::both(0.0));
        let sample = std::cell::Cell::new(seed);
        let coarse = |measured: &mut PerTrack<f64>, _: &mut Feedback| {
            let before = travel_m.get();
            let now = before.zip(*measured, |travel_m, speed| travel_m + 0.8 * speed * PERIOD_S);
            travel_m.set(now);
            let ticks = |travel_m: f64| (travel_m * 100.0).floor();
            *measured =
                now.zip(before, |now, before| (ticks(now) - ticks(before)) / 100.0 / PERIOD_S);
            sample.set(sample.get() + 1);
            if sample.get() % 20 == 0 {
                measured.left = 1.2;
            }
        };
        for leg in 0..40_u32 {
            // Every speed and turn rate, also small ones, for 0.1 to 1.9 s each.
            let draw =
                |step: u32| f64::from((leg * 7919 + seed * 104_729 + step * 31) % 101) / 100.0;
            let target = Twist::new(2.0 * draw(1) - 1.0, 2.0 * draw(2) - 1.0);
            let cause = drive.drive_for(target, 0.1 + 1.8 * draw(3), coarse);
            assert_eq!(cause, None, "seed {seed}, leg {leg}: {target:?}");
        }
    }
}

#[test]
fn reversed_track_is_found_within_a_second() {
    let mut drive = Drive::new();
    let reversed =
        |measured: &mut PerTrack<f64>, _: &mut Feedback| measured.right = -measured.right;
    let (after_s, cause) = drive.drive_for(Twist::new(0.5, 0.0), 3.0, reversed).unwrap();
    assert!(matches!(cause, StopCause::Reversed { side: Side::Right, .. }), "{cause}");
    assert!(after_s < 1.0, "{after_s}");
}

#[test]
fn runaway_is_found_at_rest_and_in_motion() {
    let runaway = |measured: &mut PerTrack<f64>, _: &mut Feedback| measured.left = 1.2;
    for target in [Twist::STOP, Twist::new(0.5, 0.0)] {
        let mut drive = Drive::new();
        assert_eq!(drive.drive_for(target, 2.0, healthy), None);
        let (after_s, cause) = drive.drive_for(target, 3.0, runaway).unwrap();
        assert!(matches!(cause, StopCause::Runaway { side: Side::Left, .. }), "{cause}");
        assert!(after_s < 0.6, "{after_s}");
    }
}

#[test]
fn only_gross_slip_is_found() {
    let turn = Twist::new(0.0, 1.5);
    for (share, found) in [(1.0, false), (0.8, false), (0.3, true), (-1.0, true)] {
        let mut drive = Drive::new();
        let slip = move |measured: &mut PerTrack<f64>, feedback: &mut Feedback| {
            feedback.yaw_rate = Some(share * (measured.right - measured.left) / 0.5);
        };
        let cause = drive.drive_for(turn, 4.0, slip);
        assert_eq!(matches!(cause, Some((_, StopCause::Slip { .. }))), found, "{share}: {cause:?}");
    }
}

#[test]
fn low_battery_is_found_but_not_voltage_sag() {
    let mut drive = Drive::new();
    let low = |_: &mut PerTrack<f64>, feedback: &mut Feedback| feedback.battery_v = Some(21.0);
    assert_eq!(drive.drive_for(Twist::STOP, 4.0, low), None);
    assert_eq!(drive.drive_for(Twist::STOP, 1.0, healthy), None);
    let (after_s, cause) = drive.drive_for(Twist::STOP, 6.0, low).unwrap();
    assert!(after_s >= 5.0, "{after_s}");
    assert!(cause.to_string().contains("21.0 V"), "{cause}");
}

#[test]
fn reported_faults_are_found_at_once() {
    let reports = |feedback: Feedback| {
        let report = move |_: &mut PerTrack<f64>, reported: &mut Feedback| *reported = feedback;
        let cause = Drive::new().drive_for(Twist::STOP, 0.1, report);
        cause.map(|(_, cause)| cause)
    };
    let faults = Faults::OVERHEATED.union(Faults::WATCHDOG);
    let fault = reports(Feedback { faults, ..Feedback::default() });
    assert_eq!(fault, Some(StopCause::Fault(Faults::OVERHEATED)));
    let button = reports(Feedback { emergency_stop: true, ..Feedback::default() });
    assert_eq!(button, Some(StopCause::EmergencyStop));
    let watchdog = reports(Feedback { faults: Faults::WATCHDOG, ..Feedback::default() });
    assert_eq!(watchdog, None);
}

#[test]
fn fault_is_kept_until_release_and_found_again_if_it_persists() {
    let mut drive = Drive::new();
    let runaway = |measured: &mut PerTrack<f64>, _: &mut Feedback| *measured = PerTrack::both(0.5);
    let (_, first) = drive.drive_for(Twist::STOP, 3.0, runaway).unwrap();
    let (after_s, kept) = drive.drive_for(Twist::STOP, 3.0, healthy).unwrap();
    assert_eq!((kept, after_s < 0.06), (first, true));
    drive.detector.release();
    assert_eq!(drive.drive_for(Twist::STOP, 3.0, healthy), None);
    assert!(drive.drive_for(Twist::STOP, 3.0, runaway).is_some());
}

#[test]
fn motion_that_is_not_finite_is_fault() {
    let settings = BaseSettings::default();
    let mut detector = FaultDetector::new(&settings, FaultDetectorSettings::default()).unwrap();
    let sample = BaseSample {
        now_s: 0.0,
        sent: Twist::STOP,
        feedback: Feedback { twist: Twist::new(f64::NAN, 0.0), ..Feedback::default() },
    };
    assert_eq!(detector.update(&sample), Some(&StopCause::NotFinite));
}

#[test]
fn faults_display_every_name_and_keep_every_bit() {
    assert_eq!(Faults::NONE.to_string(), "none");
    let two = Faults::OVERHEATED.union(Faults::STALLED);
    assert_eq!(two.to_string(), "overheated, stalled track");
    assert_eq!(Faults::from_bits(0x0400), Faults::OTHER);
    for bit in 0..16 {
        let fault = Faults::from_bits(1 << bit);
        assert!(!fault.is_empty() && fault.to_string() != "none", "{bit}");
        assert_eq!(Faults::from_bits(fault.bits()), fault);
    }
}

/// 0.2 s is permitted; a delay above it is a fault when it lasts.
#[test]
fn delayed_commands_are_a_fault_from_their_limit() {
    for (delay_s, expected) in [(0.19, false), (0.21, true)] {
        let settings = FaultDetectorSettings::default();
        let mut detector = FaultDetector::new(&BaseSettings::default(), settings).expect("valid");
        let feedback = Feedback { command_delay_s: Some(delay_s), ..Feedback::default() };
        let found = (0..60).find_map(|sample| {
            let now_s = PERIOD_S * f64::from(sample);
            detector.update(&BaseSample { now_s, sent: Twist::STOP, feedback }).copied()
        });
        let is_found = matches!(found, Some(StopCause::CommandDelay { .. }));
        assert_eq!(is_found, expected, "{delay_s} s: {found:?}");
    }
}
