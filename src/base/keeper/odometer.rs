//! Where a base has come to by what it reports: from its encoders where it has them, else from its speeds.

use crate::base::tick_meter::{can_run, highest_m_s};
use crate::base::{BaseSettings, Feedback};
use crate::geometry::Pose;
use crate::robot::{PerTrack, TrackOdometry, travel_m};

/// Longest time that a reported speed is taken to last, seconds: ten reports of the slowest controller.
const LONGEST_S: f64 = 0.5;

/// Adds up a base's reports to a pose, from where it stood at the first.
#[derive(Clone, Debug)]
pub struct Odometer {
    tracks: TrackOdometry,
    ticks_per_m: PerTrack<f64>,
    most_m_s: f64,
    /// The counters before the base was not heard for a while, and when they were read.
    before: Option<(f64, PerTrack<u32>)>,
    /// The newest counters, if it has any.
    ticks: Option<PerTrack<u32>>,
    /// When the last report came.
    last_s: Option<f64>,
    /// The pose that those made.
    by_speeds: Option<Pose>,
    travelled_m: f64,
}

impl Odometer {
    /// An odometer that has seen nothing. The settings are valid.
    #[must_use]
    pub fn new(base: &BaseSettings) -> Self {
        Self {
            tracks: TrackOdometry::new(base.drive(), base.ticks_per_m, Pose::default()),
            ticks_per_m: base.ticks_per_m,
            most_m_s: highest_m_s(base),
            before: None,
            ticks: None,
            last_s: None,
            by_speeds: None,
            travelled_m: 0.0,
        }
    }

    /// Takes the newest report, which may be the same again.
    pub fn take(&mut self, feedback: &Feedback, now_s: f64) {
        let elapsed_s = now_s - self.last_s.replace(now_s).unwrap_or(now_s);
        if let Some(ticks) = feedback.ticks {
            self.take_up(&ticks, now_s);
            self.ticks = Some(ticks);
            self.travelled_m += self.tracks.read(ticks).linear.abs();
            return;
        }
        let elapsed_s = elapsed_s.clamp(0.0, LONGEST_S);
        if feedback.twist.is_finite() {
            let pose = self.by_speeds.unwrap_or_default();
            self.by_speeds = Some(pose.after(&feedback.twist, elapsed_s));
            self.travelled_m += feedback.twist.linear.abs() * elapsed_s;
        }
    }

    /// The base is not heard for a while. Counters tell afterwards what it did; where they have begun anew, or there are
    /// none, that is not known and counts as nothing.
    pub fn interrupt(&mut self) {
        self.before = self.last_s.take().zip(self.ticks).or(self.before);
    }

    /// Goes on from the counters of before an interruption, if the tracks can have run so far since.
    fn take_up(&mut self, ticks: &PerTrack<u32>, now_s: f64) {
        if let Some((before_s, before)) = self.before.take()
            && !can_run(
                &travel_m(&before, ticks, &self.ticks_per_m),
                now_s - before_s,
                self.most_m_s,
            )
        {
            self.tracks.reset_counters();
        }
    }

    /// Where the base is, of where it stood at the first report.
    #[must_use]
    pub fn pose(&self) -> Pose {
        self.by_speeds.unwrap_or(*self.tracks.pose())
    }

    /// Way of its middle, either way, metres.
    #[must_use]
    pub const fn travelled_m(&self) -> f64 {
        self.travelled_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Twist;
    use crate::robot::PerTrack;

    #[test]
    fn ticks_and_speeds_lead_to_the_same_place() {
        let base = BaseSettings::default();
        let (mut ticks, mut speeds) = (Odometer::new(&base), Odometer::new(&base));
        for step in 0..=100_u32 {
            let now_s = 0.02 * f64::from(step);
            // 0.4 and 0.6 m/s at 10,000 ticks a metre.
            let by_ticks = Feedback {
                ticks: Some(PerTrack::new(80 * step, 120 * step)),
                ..Feedback::default()
            };
            ticks.take(&by_ticks, now_s);
            ticks.take(&by_ticks, now_s);
            let by_speeds = Feedback {
                twist: Twist::new(0.5, 0.4),
                ..Feedback::default()
            };
            speeds.take(&by_speeds, now_s);
        }
        let (one, other) = (ticks.pose(), speeds.pose());
        assert!(
            (one.position() - other.position()).norm() < 1e-6,
            "{one:?} {other:?}"
        );
        assert!((one.yaw - 0.8).abs() < 1e-6 && (other.yaw - 0.8).abs() < 1e-6);
        assert!((ticks.travelled_m() - 1.0).abs() < 1e-6);
    }

    #[test]
    fn counters_tell_what_was_done_unheard_unless_they_began_anew() {
        let base = BaseSettings::default();
        let mut odometer = Odometer::new(&base);
        let at = |ticks| Feedback {
            ticks: Some(PerTrack::both(ticks)),
            ..Feedback::default()
        };
        let x_m = |odometer: &Odometer| odometer.pose().x;
        odometer.take(&at(0), 0.0);
        odometer.take(&at(1000), 0.1);
        odometer.interrupt();
        // Attempts in vain to open the line.
        odometer.interrupt();
        odometer.take(&at(9000), 5.0);
        assert!((x_m(&odometer) - 0.9).abs() < 1e-12, "{odometer:?}");
        odometer.interrupt();
        odometer.take(&at(90_000), 6.0);
        odometer.take(&at(90_100), 6.1);
        assert!((x_m(&odometer) - 0.91).abs() < 1e-12, "{odometer:?}");
        assert!((odometer.travelled_m() - 0.91).abs() < 1e-12);
    }

    #[test]
    fn what_is_done_unheard_without_counters_counts_as_nothing() {
        let mut odometer = Odometer::new(&BaseSettings::default());
        let feedback = Feedback {
            twist: Twist::new(0.5, 0.0),
            ..Feedback::default()
        };
        odometer.take(&feedback, 0.0);
        odometer.take(&feedback, 0.2);
        odometer.interrupt();
        odometer.take(&feedback, 0.6);
        odometer.take(&feedback, 0.8);
        assert!((odometer.pose().x - 0.2).abs() < 1e-12, "{odometer:?}");
    }
}
