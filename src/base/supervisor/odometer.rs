//! Pose of a base from its reports: from its encoders if it has them, else from its speeds.

use crate::base::encoder_speed::{
    SpeedRange, are_counters_reset, is_plausible_travel, max_plausible_speed,
};
use crate::base::{BaseSettings, Faults, Feedback};
use crate::geometry::Pose;
use crate::robot::{PerTrack, TrackOdometry, TrackedDrive, travel_m};

/// Longest time a reported speed is integrated over, seconds: ten reports of the slowest controller.
const MAX_STEP_S: f64 = 0.5;

/// Integrates a base's reports to a pose relative to the first report.
#[derive(Clone, Debug)]
pub(super) struct Odometer {
    drive: TrackedDrive,
    tracks: TrackOdometry,
    ticks_per_m: PerTrack<f64>,
    max_speed_m_s: f64,
    /// Time and counts of the last report before an interruption, with its speeds.
    before: Option<(f64, (PerTrack<u32>, SpeedRange))>,
    /// The latest counts, for a base with encoders, with the speeds reported then.
    latest: Option<(PerTrack<u32>, SpeedRange)>,
    /// Time of the newest report.
    last_s: Option<f64>,
    /// The pose integrated from speeds, for a base without encoders.
    by_speeds: Option<Pose>,
    travelled_m: f64,
    /// Whether the latest report has [`Faults::ENCODER`].
    has_encoder_fault: bool,
    is_uncertain: bool,
}

impl Odometer {
    /// Creates an odometer without reports. The settings are valid.
    pub(super) fn new(base: &BaseSettings) -> Self {
        Self {
            drive: base.drive(),
            tracks: TrackOdometry::new(base.drive(), base.ticks_per_m, Pose::default()),
            ticks_per_m: base.ticks_per_m,
            max_speed_m_s: max_plausible_speed(base),
            before: None,
            latest: None,
            last_s: None,
            by_speeds: None,
            travelled_m: 0.0,
            has_encoder_fault: false,
            is_uncertain: false,
        }
    }

    /// Takes the latest report, which may be the previous one again. The pose is that at the time of the newest report, whenever
    /// that arrived: speeds are integrated from report to report.
    pub(super) fn update(&mut self, feedback: &Feedback, now_s: f64) {
        let stamp_s = now_s - feedback.age_s;
        let before_s = self.last_s.unwrap_or(stamp_s);
        // The time of a report that comes again is the same only to some microseconds.
        self.last_s = Some(before_s.max(stamp_s));
        let elapsed_s = stamp_s - before_s;
        if let Some(counts) = feedback.encoder_counts {
            let has_fault = feedback.faults.contains(Faults::ENCODER);
            let has_jumped = has_fault && !self.has_encoder_fault;
            self.has_encoder_fault = has_fault;
            if self.is_reset(&counts, stamp_s) || has_jumped {
                self.tracks.reset_counters();
                self.is_uncertain = true;
            }
            let mut range = SpeedRange::default();
            range.include(&self.drive.tracks(&feedback.twist));
            self.latest = Some((counts, range));
            self.travelled_m += self.tracks.update(counts).linear.abs();
            return;
        }
        let elapsed_s = elapsed_s.clamp(0.0, MAX_STEP_S);
        if feedback.twist.is_finite() {
            let pose = self.by_speeds.unwrap_or_default();
            self.by_speeds = Some(pose.after(&feedback.twist, elapsed_s));
            self.travelled_m += feedback.twist.linear.abs() * elapsed_s;
        }
    }

    /// Marks the start of a time without reports. The encoder counts afterwards give the motion meanwhile; without encoders,
    /// or after a counter reset, that motion is unknown and counts as zero.
    pub(super) fn interrupt(&mut self) {
        self.is_uncertain |= self.by_speeds.is_some();
        self.before = self.last_s.take().zip(self.latest).or(self.before);
    }

    /// Whether the first counts after an interruption do not continue those before it: the tracks cannot have run that far meanwhile, or
    /// the counters were reset.
    fn is_reset(&mut self, counts: &PerTrack<u32>, stamp_s: f64) -> bool {
        self.before.take().is_some_and(|(before_s, (before, range))| {
            let (elapsed_s, per_m) = (stamp_s - before_s, &self.ticks_per_m);
            let travelled_m = travel_m(&before, counts, per_m);
            !is_plausible_travel(&travelled_m, elapsed_s, self.max_speed_m_s)
                || are_counters_reset((&before, counts), per_m, &range, elapsed_s)
        })
    }

    /// Pose relative to the first report.
    pub(super) fn pose(&self) -> Pose {
        self.by_speeds.unwrap_or(*self.tracks.pose())
    }

    /// Whether pose and distance lack a motion: counters jumped or were reset, or a base without encoders did not report for a time.
    pub(super) const fn is_uncertain(&self) -> bool {
        self.is_uncertain
    }

    /// Distance travelled by the base's centre, forwards and backwards, metres.
    pub(super) const fn travelled_m(&self) -> f64 {
        self.travelled_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Twist;
    use crate::robot::PerTrack;

    #[test]
    fn odometer_gives_same_pose_from_counts_and_speeds() {
        let base = BaseSettings::default();
        let (mut counts, mut speeds) = (Odometer::new(&base), Odometer::new(&base));
        for step in 0..=100_u32 {
            let now_s = 0.02 * f64::from(step);
            // 0.4 and 0.6 m/s at 10,000 ticks per metre.
            let by_counts = Feedback {
                encoder_counts: Some(PerTrack::new(80 * step, 120 * step)),
                ..Feedback::default()
            };
            counts.update(&by_counts, now_s);
            counts.update(&by_counts, now_s);
            let by_speeds = Feedback { twist: Twist::new(0.5, 0.4), ..Feedback::default() };
            speeds.update(&by_speeds, now_s);
        }
        let (one, other) = (counts.pose(), speeds.pose());
        assert!((one.position() - other.position()).norm() < 1e-6, "{one:?} {other:?}");
        assert!((one.yaw - 0.8).abs() < 1e-6 && (other.yaw - 0.8).abs() < 1e-6);
        assert!((counts.travelled_m() - 1.0).abs() < 1e-6);
    }

    #[test]
    fn odometer_bridges_interruption_unless_counters_reset() {
        let base = BaseSettings::default();
        let mut odometer = Odometer::new(&base);
        let at =
            |count| Feedback { encoder_counts: Some(PerTrack::both(count)), ..Feedback::default() };
        let x_m = |odometer: &Odometer| odometer.pose().x;
        odometer.update(&at(0), 0.0);
        odometer.update(&at(1000), 0.1);
        odometer.interrupt();
        // A failed attempt to reconnect.
        odometer.interrupt();
        odometer.update(&at(9000), 5.0);
        assert!((x_m(&odometer) - 0.9).abs() < 1e-12, "{odometer:?}");
        odometer.interrupt();
        odometer.update(&at(90_000), 6.0);
        odometer.update(&at(90_100), 6.1);
        assert!((x_m(&odometer) - 0.91).abs() < 1e-12, "{odometer:?}");
        assert!((odometer.travelled_m() - 0.91).abs() < 1e-12);
    }

    /// A base that drove 1.5 m at 0.3 m/s, and was without power for 2 s: in this time a track can run 3.8 m.
    #[test]
    fn counters_reset_in_an_interruption_are_no_motion() {
        for (count, x_m, travelled_m) in [
            (0, 1.5, 1.5),
            (300, 1.5, 1.5),
            (19_000, 1.9, 1.9),
            (15_000, 1.5, 1.5),
            (14_000, 1.4, 1.6),
        ] {
            let mut odometer = Odometer::new(&BaseSettings::default());
            let twist = Twist::new(0.3, 0.0);
            let at = |count| Feedback {
                twist,
                encoder_counts: Some(PerTrack::both(count)),
                ..Feedback::default()
            };
            for step in 0..=50_u32 {
                odometer.update(&at(300 * step), 0.1 * f64::from(step));
            }
            odometer.interrupt();
            odometer.update(&at(count), 7.0);
            assert!((odometer.pose().x - x_m).abs() < 1e-12, "{count}: {odometer:?}");
            assert!((odometer.travelled_m() - travelled_m).abs() < 1e-12, "{count}: {odometer:?}");
            assert_eq!(odometer.is_uncertain(), count < 1000, "{count}");
        }
    }

    /// The session has accepted counts that jumped, and says so.
    #[test]
    fn counters_that_jump_with_a_fault_are_no_motion() {
        let mut odometer = Odometer::new(&BaseSettings::default());
        let at = |count, faults| Feedback {
            encoder_counts: Some(PerTrack::both(count)),
            faults,
            ..Feedback::default()
        };
        odometer.update(&at(0, Faults::NONE), 0.0);
        odometer.update(&at(9000, Faults::NONE), 1.0);
        assert!(!odometer.is_uncertain());
        odometer.update(&at(20, Faults::ENCODER), 1.1);
        odometer.update(&at(120, Faults::ENCODER), 1.2);
        assert!((odometer.pose().x - 0.91).abs() < 1e-12, "{odometer:?}");
        assert!((odometer.travelled_m() - 0.91).abs() < 1e-12 && odometer.is_uncertain());
        odometer.update(&at(220, Faults::NONE), 1.3);
        odometer.update(&at(0, Faults::ENCODER), 1.4);
        assert!((odometer.pose().x - 0.92).abs() < 1e-12, "{odometer:?}");
    }

    /// A report every 0.05 s, as of WHEELTEC, which is read every 0.02 s.
    #[test]
    fn pose_from_speeds_is_that_at_the_time_of_the_report() {
        let mut odometer = Odometer::new(&BaseSettings::default());
        let turn_rate = 1.0;
        for cycle in 3..300 {
            let now_s = 0.02 * f64::from(cycle);
            let stamp_s = 0.05 * (now_s / 0.05 + 1e-9).floor();
            // The clock is read at a slightly different time in each cycle.
            let age_s = now_s - stamp_s + 1e-5 * f64::from(cycle % 3);
            let twist = Twist::new(0.0, turn_rate);
            odometer.update(&Feedback { twist, age_s, ..Feedback::default() }, now_s);
            let turned = odometer.pose().yaw - turn_rate * (stamp_s - 0.05);
            assert!(crate::geometry::wrap_angle(turned).abs() < 1e-4, "{now_s} s: {turned}");
        }
    }

    #[test]
    fn odometer_without_encoders_ignores_motion_during_interruption() {
        let mut odometer = Odometer::new(&BaseSettings::default());
        let feedback = Feedback { twist: Twist::new(0.5, 0.0), ..Feedback::default() };
        odometer.update(&feedback, 0.0);
        odometer.update(&feedback, 0.2);
        odometer.interrupt();
        odometer.update(&feedback, 0.6);
        odometer.update(&feedback, 0.8);
        assert!((odometer.pose().x - 0.2).abs() < 1e-12, "{odometer:?}");
    }

    #[test]
    fn odometer_integrates_a_speed_over_at_most_half_a_second() {
        let after = |elapsed_s: f64, linear: f64| {
            let mut odometer = Odometer::new(&BaseSettings::default());
            let feedback = Feedback { twist: Twist::new(linear, 0.0), ..Feedback::default() };
            odometer.update(&feedback, 10.0);
            odometer.update(&feedback, 10.0 + elapsed_s);
            (odometer.pose().x, odometer.travelled_m())
        };
        for (elapsed_s, expected_m) in [(0.4, 0.4), (3.0, 0.5), (-1.0, 0.0)] {
            let (x_m, travelled_m) = after(elapsed_s, 1.0);
            assert!((x_m - expected_m).abs() < 1e-9 && (travelled_m - expected_m).abs() < 1e-9);
        }
        assert_eq!(after(0.4, f64::NAN), (0.0, 0.0));
        assert_eq!(after(0.4, f64::INFINITY), (0.0, 0.0));
    }
}
