//! The fault detector finds each fault in time, and none on a healthy base.

use inbye::base::{
    BaseSample, BaseSettings, FaultDetector, FaultDetectorSettings, Faults, Feedback, StopCause,
};
use inbye::geometry::Twist;
use inbye::robot::{Mixer, PerTrack, Side};

/// Sample period, seconds.
const PERIOD_S: f64 = 0.05;
/// Time constant of the motors, seconds.
const LAG_S: f64 = 0.1;

/// A base with a fault, driven by ramped commands.
struct Drive {
    detector: FaultDetector,
    mixer: Mixer,
    settings: BaseSettings,
    speeds: PerTrack<f64>,
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
            let share = 1.0 - libm::exp(-PERIOD_S / LAG_S);
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
