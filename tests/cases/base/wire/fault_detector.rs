//! The judge of what a base does: each fault is found in time and named, and a healthy base is left alone.

use inbye::base::{
    BaseSample, BaseSettings, FaultDetector, FaultDetectorSettings, Faults, Feedback, StopCause,
};
use inbye::geometry::Twist;
use inbye::robot::{Mixer, PerTrack, Side};

/// Time of a look, seconds.
const LOOK_S: f64 = 0.05;
/// Time constant of the motors, seconds.
const LAG_S: f64 = 0.1;

/// A base with a fault, driven by ramped commands under the eyes of the judge.
struct Drive {
    judge: FaultDetector,
    mixer: Mixer,
    settings: BaseSettings,
    speeds: PerTrack<f64>,
    now_s: f64,
}

impl Drive {
    fn new() -> Self {
        let settings = BaseSettings {
            min_battery_v: Some(22.0),
            ..BaseSettings::default()
        };
        Self {
            judge: FaultDetector::new(&settings, FaultDetectorSettings::default())
                .expect("valid settings"),
            mixer: Mixer::new(settings.drive(), settings.tracks),
            settings,
            speeds: PerTrack::both(0.0),
            now_s: 0.0,
        }
    }

    /// Drives for a time, and returns when the judge spoke, counted from now, and what it said.
    fn keep_on(
        &mut self,
        wanted: Twist,
        time_s: f64,
        fault: impl Fn(&mut PerTrack<f64>, &mut Feedback),
    ) -> Option<(f64, StopCause)> {
        let start_s = self.now_s;
        for _ in 0..(time_s / LOOK_S).round() as usize {
            self.now_s += LOOK_S;
            let told = self.mixer.mix(&wanted, LOOK_S);
            let share = 1.0 - libm::exp(-LOOK_S / LAG_S);
            self.speeds = self
                .speeds
                .zip(told.into(), |now, told| now + share * (told - now));
            let mut measured = self.speeds;
            let mut feedback = Feedback {
                battery_v: Some(24.0),
                ..Feedback::default()
            };
            fault(&mut measured, &mut feedback);
            feedback.twist = self.settings.drive().twist(&measured.into());
            if feedback.yaw_rate.is_none() {
                feedback.yaw_rate = Some(feedback.twist.angular);
            }
            let look = BaseSample {
                now_s: self.now_s,
                sent: self.mixer.twist(&told),
                feedback,
            };
            if let Some(verdict) = self.judge.update(&look) {
                return Some((self.now_s - start_s, *verdict));
            }
        }
        None
    }
}

fn healthy(_: &mut PerTrack<f64>, _: &mut Feedback) {}

#[test]
fn a_healthy_base_is_left_alone_through_starts_reversals_and_turns() {
    let mut drive = Drive::new();
    for round in 0..5 {
        for wanted in [
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
            let verdict = drive.keep_on(wanted, time_s, healthy);
            assert_eq!(verdict, None, "{wanted:?}");
        }
    }
}

#[test]
fn a_stuck_track_is_found_on_its_side_and_says_so() {
    for side in [Side::Left, Side::Right] {
        let mut drive = Drive::new();
        let stuck = move |measured: &mut PerTrack<f64>, _: &mut Feedback| match side {
            Side::Left => measured.left = 0.002,
            Side::Right => measured.right = 0.002,
        };
        let (after_s, verdict) = drive.keep_on(Twist::new(0.5, 0.0), 3.0, stuck).unwrap();
        assert!(
            matches!(verdict, StopCause::Stuck { side: found, .. } if found == side),
            "{verdict}"
        );
        // A ramp to 0.1 m/s, and a second.
        assert!(after_s > 1.0 && after_s < 1.3, "{after_s}");
        let words =
            format!("the {side} track stands (measured 0.00 m/s) though it is told 0.50 m/s");
        assert!(verdict.to_string().starts_with(&words), "{verdict}");
    }
}

#[test]
fn a_reversed_track_is_found_before_it_has_gone_far() {
    let mut drive = Drive::new();
    let reversed =
        |measured: &mut PerTrack<f64>, _: &mut Feedback| measured.right = -measured.right;
    let (after_s, verdict) = drive.keep_on(Twist::new(0.5, 0.0), 3.0, reversed).unwrap();
    assert!(
        matches!(
            verdict,
            StopCause::Reversed {
                side: Side::Right,
                ..
            }
        ),
        "{verdict}"
    );
    assert!(after_s < 1.0, "{after_s}");
}

#[test]
fn a_runaway_is_found_at_rest_and_under_way() {
    let away = |measured: &mut PerTrack<f64>, _: &mut Feedback| measured.left = 1.2;
    for wanted in [Twist::STOP, Twist::new(0.5, 0.0)] {
        let mut drive = Drive::new();
        assert_eq!(drive.keep_on(wanted, 2.0, healthy), None);
        let (after_s, verdict) = drive.keep_on(wanted, 3.0, away).unwrap();
        assert!(
            matches!(
                verdict,
                StopCause::Runaway {
                    side: Side::Left,
                    ..
                }
            ),
            "{verdict}"
        );
        assert!(after_s < 0.6, "{after_s}");
    }
}

#[test]
fn slip_is_found_by_the_gyro_and_only_where_it_is_gross() {
    let turn = Twist::new(0.0, 1.5);
    for (share, found) in [(1.0, false), (0.8, false), (0.3, true), (-1.0, true)] {
        let mut drive = Drive::new();
        let slip = move |measured: &mut PerTrack<f64>, feedback: &mut Feedback| {
            feedback.yaw_rate = Some(share * (measured.right - measured.left) / 0.5);
        };
        let verdict = drive.keep_on(turn, 4.0, slip);
        assert_eq!(
            matches!(verdict, Some((_, StopCause::Slip { .. }))),
            found,
            "{share}: {verdict:?}"
        );
    }
}

#[test]
fn a_low_battery_is_found_and_a_sagging_one_is_not() {
    let mut drive = Drive::new();
    let low = |_: &mut PerTrack<f64>, feedback: &mut Feedback| feedback.battery_v = Some(21.0);
    assert_eq!(drive.keep_on(Twist::STOP, 4.0, low), None);
    assert_eq!(drive.keep_on(Twist::STOP, 1.0, healthy), None);
    let (after_s, verdict) = drive.keep_on(Twist::STOP, 6.0, low).unwrap();
    assert!(after_s >= 5.0, "{after_s}");
    assert!(verdict.to_string().contains("21.0 V"), "{verdict}");
}

#[test]
fn what_the_base_says_itself_is_found_at_once() {
    let reports = |feedback: Feedback| {
        let say = move |_: &mut PerTrack<f64>, said: &mut Feedback| *said = feedback;
        let verdict = Drive::new().keep_on(Twist::STOP, 0.1, say);
        verdict.map(|(_, verdict)| verdict)
    };
    let faults = Faults::OVERHEATED.union(Faults::WATCHDOG);
    let fault = reports(Feedback {
        faults,
        ..Feedback::default()
    });
    assert_eq!(fault, Some(StopCause::Fault(Faults::OVERHEATED)));
    let button = reports(Feedback {
        emergency_stop: true,
        ..Feedback::default()
    });
    assert_eq!(button, Some(StopCause::EmergencyStop));
    let watchdog = reports(Feedback {
        faults: Faults::WATCHDOG,
        ..Feedback::default()
    });
    assert_eq!(watchdog, None);
}

#[test]
fn a_verdict_is_kept_until_it_is_released_and_found_again_where_it_still_holds() {
    let mut drive = Drive::new();
    let away = |measured: &mut PerTrack<f64>, _: &mut Feedback| *measured = PerTrack::both(0.5);
    let (_, first) = drive.keep_on(Twist::STOP, 3.0, away).unwrap();
    let (after_s, kept) = drive.keep_on(Twist::STOP, 3.0, healthy).unwrap();
    assert_eq!((kept, after_s < 0.06), (first, true));
    drive.judge.release();
    assert_eq!(drive.keep_on(Twist::STOP, 3.0, healthy), None);
    assert!(drive.keep_on(Twist::STOP, 3.0, away).is_some());
}

#[test]
fn motion_that_is_not_a_number_is_refused() {
    let settings = BaseSettings::default();
    let mut judge = FaultDetector::new(&settings, FaultDetectorSettings::default()).unwrap();
    let look = BaseSample {
        now_s: 0.0,
        sent: Twist::STOP,
        feedback: Feedback {
            twist: Twist::new(f64::NAN, 0.0),
            ..Feedback::default()
        },
    };
    assert_eq!(judge.update(&look), Some(&StopCause::NotFinite));
}
