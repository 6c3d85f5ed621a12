//! Track speeds from encoder counts, and rejection of implausible counts.

use std::collections::VecDeque;

use super::{BaseSettings, Faults};
use crate::robot::{PerTrack, TrackSpeeds, travel_m};

/// Averaging time of speeds, seconds: three readings at 30 Hz, so that neither one tick nor a late byte changes the speed much.
const WINDOW_S: f64 = 0.1;

/// Factor by which a track may exceed its highest speed: downhill, or because a setting is inaccurate.
const SPEED_MARGIN: f64 = 1.5;

/// Time by which readings may be early or late, seconds: a USB adapter delays bytes for up to 16 ms, and a busy host longer.
const JITTER_S: f64 = 0.05;

/// Time between two readings in which a base can have lost its power and started again, seconds.
const OUTAGE_S: f64 = 0.15;

/// Travel of each track from zero within which the first reading after a reset of the counters lies, metres: a base without power coasts,
/// and gets its next command soon after it has started.
const NEAR_ZERO_M: f64 = 0.25;

/// Travel beyond that of the commanded and measured speeds that is no sign of a reset, metres: a base sways when it stops.
const SWAY_M: f64 = 0.05;

/// Number of consecutive rejected readings that agree with one another after which the counter itself has jumped.
const CONSISTENT_READINGS: u32 = 3;

/// Counts of both tracks.
#[derive(Clone, Copy, Debug)]
struct Reading {
    counts: PerTrack<u32>,
    /// Time of the reading, seconds.
    time_s: f64,
    /// Time at which it was made at the earliest, seconds.
    earliest_s: f64,
    /// Speeds that the tracks may have had since the reading before.
    range: SpeedRange,
}

/// The lowest and the highest speed that each track may have had, m/s. Zero is always among them: a base may stand.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SpeedRange {
    lowest: TrackSpeeds,
    highest: TrackSpeeds,
}

impl SpeedRange {
    /// Extends the range to these speeds, m/s.
    pub(super) fn include(&mut self, speeds: &TrackSpeeds) {
        self.join(&Self { lowest: *speeds, highest: *speeds });
    }

    fn join(&mut self, other: &Self) {
        self.lowest = self.lowest.zip(other.lowest, f64::min);
        self.highest = self.highest.zip(other.highest, f64::max);
    }

    /// Whether both tracks can have travelled this distance, metres, in this time, seconds.
    fn explains(&self, travelled_m: &PerTrack<f64>, elapsed_s: f64) -> bool {
        let farthest_m = |speed: f64| SPEED_MARGIN * speed * (elapsed_s + JITTER_S);
        let above = travelled_m.zip(self.lowest, |m, lowest| m >= farthest_m(lowest) - SWAY_M);
        let below = travelled_m.zip(self.highest, |m, highest| m <= farthest_m(highest) + SWAY_M);
        above.left && above.right && below.left && below.right
    }
}

/// Derives speeds from recent readings of both encoders.
#[derive(Clone, Debug)]
pub(super) struct EncoderSpeed {
    ticks_per_m: PerTrack<f64>,
    max_speed_m_s: f64,
    readings: VecDeque<Reading>,
    /// The last reading, if it was rejected, and the number of consecutive rejected readings that agree with it, including it.
    rejected: Option<(Reading, u32)>,
    /// Arrival of the last answer, seconds; none for a base with a clock of its own.
    arrived_s: Option<f64>,
    rejections: u64,
    has_jumped: bool,
    /// The last command, and all speeds that the tracks may have had since the last reading that was taken.
    commanded: TrackSpeeds,
    range: SpeedRange,
}

impl EncoderSpeed {
    pub(super) fn new(settings: &BaseSettings) -> Self {
        Self {
            ticks_per_m: settings.ticks_per_m,
            max_speed_m_s: max_plausible_speed(settings),
            readings: VecDeque::new(),
            rejected: None,
            arrived_s: None,
            rejections: 0,
            has_jumped: false,
            commanded: TrackSpeeds::default(),
            range: SpeedRange::default(),
        }
    }

    /// Takes the speeds, m/s, of a command that goes to the base.
    pub(super) fn command(&mut self, speeds: &TrackSpeeds) {
        self.commanded = *speeds;
        self.range.include(speeds);
    }

    /// Takes the counts of both tracks at a time by the base's clock, seconds, and returns their speeds. Returns none if no track
    /// can have run that far since the last reading, if time ran backwards, or if the counters seem to have been reset. The third
    /// consecutive rejected reading that agrees with the others restarts the measurement and sets [`Faults::ENCODER`].
    pub(super) fn update(&mut self, counts: PerTrack<u32>, time_s: f64) -> Option<TrackSpeeds> {
        self.take(Reading { counts, time_s, earliest_s: time_s, range: self.range })
    }

    /// As [`Self::update`], for an answer of a base without a clock, with its time of arrival, seconds.
    ///
    /// An answer may wait in a buffer, or for a busy host, and the next one then arrives right after it. The base made it after the
    /// previous answer, since one request is outstanding at a time.
    pub(super) fn update_on_arrival(
        &mut self,
        counts: PerTrack<u32>,
        arrived_s: f64,
    ) -> Option<TrackSpeeds> {
        let earliest_s = self.arrived_s.replace(arrived_s).unwrap_or(arrived_s);
        self.take(Reading { counts, time_s: arrived_s, earliest_s, range: self.range })
    }

    fn take(&mut self, reading: Reading) -> Option<TrackSpeeds> {
        let Reading { counts, time_s, .. } = reading;
        if self.readings.back().is_some_and(|last| !self.is_plausible(last, &reading)) {
            self.rejections += 1;
            let consistent = match &self.rejected {
                Some((last, consistent)) if self.is_plausible(last, &reading) => consistent + 1,
                _ => 1,
            };
            if consistent < CONSISTENT_READINGS {
                self.rejected = Some((reading, consistent));
                return None;
            }
            self.has_jumped = true;
            self.readings.clear();
        }
        self.rejected = None;
        // A base's clock may stand still, or a report come twice. Only one reading per time is kept, or readings would never
        // leave the window.
        if self.readings.len() > 1 && self.readings.back().is_some_and(|last| last.time_s == time_s)
        {
            self.readings.pop_back();
        }
        self.readings.push_back(reading);
        while self.readings.len() > 2 && time_s - self.readings[1].time_s >= WINDOW_S {
            self.readings.pop_front();
        }
        let first = self.readings[0];
        let elapsed_s = time_s - first.time_s;
        let travelled_m = travel_m(&first.counts, &counts, &self.ticks_per_m);
        let speed = |travelled_m: f64| if elapsed_s > 0.0 { travelled_m / elapsed_s } else { 0.0 };
        let speeds = travelled_m.map(speed);
        self.range = SpeedRange::default();
        self.range.include(&self.commanded);
        self.range.include(&speeds);
        Some(speeds)
    }

    /// Whether the tracks can have run from one reading to the next, and the counters were not reset in between.
    fn is_plausible(&self, before: &Reading, now: &Reading) -> bool {
        let travelled_m = travel_m(&before.counts, &now.counts, &self.ticks_per_m);
        let elapsed_s = now.time_s - before.earliest_s;
        let can_have_run = is_plausible_travel(&travelled_m, elapsed_s, self.max_speed_m_s);
        if !can_have_run || elapsed_s <= OUTAGE_S {
            return can_have_run;
        }
        // Readings that waited for a busy host arrive together: the speeds of all recent ones count.
        let mut range = now.range;
        self.readings.iter().for_each(|reading| range.join(&reading.range));
        let counts = (&before.counts, &now.counts);
        !are_counters_reset(counts, &self.ticks_per_m, &range, elapsed_s)
    }

    /// Number of rejected readings.
    pub(super) const fn rejected(&self) -> u64 {
        self.rejections
    }

    /// [`Faults::ENCODER`] after a counter jumped, until it is cleared.
    pub(super) const fn faults(&self) -> Faults {
        Faults::ENCODER.when(self.has_jumped)
    }

    /// Clears the fault.
    pub(super) fn clear_fault(&mut self) {
        self.has_jumped = false;
    }
}

/// Whether tracks can run this distance in this time, seconds, at the speed of [`max_plausible_speed`].
pub(super) fn is_plausible_travel(
    travelled_m: &PerTrack<f64>,
    elapsed_s: f64,
    max_speed_m_s: f64,
) -> bool {
    elapsed_s >= 0.0 && farther(travelled_m) <= max_speed_m_s * (elapsed_s + JITTER_S)
}

/// Whether a base without power has lost its counts between two readings, the earlier one first: both counters are near zero, and the
/// tracks cannot have travelled there at the speeds of the range in this time, seconds.
pub(super) fn are_counters_reset(
    (before, now): (&PerTrack<u32>, &PerTrack<u32>),
    ticks_per_m: &PerTrack<f64>,
    range: &SpeedRange,
    elapsed_s: f64,
) -> bool {
    farther(&travel_m(&PerTrack::both(0), now, ticks_per_m)) <= NEAR_ZERO_M
        && !range.explains(&travel_m(before, now, ticks_per_m), elapsed_s)
}

/// Distance of the track that travelled farther, in either direction.
fn farther(travelled_m: &PerTrack<f64>) -> f64 {
    travelled_m.left.abs().max(travelled_m.right.abs())
}

/// The highest plausible speed of a track, m/s.
pub(super) fn max_plausible_speed(settings: &BaseSettings) -> f64 {
    SPEED_MARGIN * settings.tracks.max_track_speed
}

#[cfg(test)]
mod tests {
    use super::*;

    fn encoder_speed() -> EncoderSpeed {
        EncoderSpeed::new(&BaseSettings::default())
    }

    #[test]
    fn constant_time_keeps_two_readings() {
        let mut speed = encoder_speed();
        for tick in 0..1000 {
            assert!(speed.update(PerTrack::both(tick), 3.0).is_some());
        }
        assert_eq!(speed.readings.len(), 2);
    }

    #[test]
    fn readings_older_than_the_window_are_dropped() {
        let mut speed = encoder_speed();
        for tick in 0..20_u32 {
            assert!(speed.update(PerTrack::both(100 * tick), 0.02 * f64::from(tick)).is_some());
        }
        assert!(speed.readings.len() <= 7, "{}", speed.readings.len());
    }

    /// Readings every 20 ms of a base that was commanded 0.3 m/s and drove for 3 s, then one after an outage, as metres of both tracks.
    fn after_outage(outage_s: f64, commanded: f64, metres: [f64; 2]) -> (EncoderSpeed, [bool; 3]) {
        let mut speed = encoder_speed();
        let counts = |metres: f64| (10_000.0 * metres) as i64 as u32;
        for step in 0..=150 {
            let now_s = 0.02 * f64::from(step);
            speed.command(&PerTrack::both(0.3));
            let counts = counts(0.3 * now_s);
            assert!(speed.update_on_arrival(PerTrack::both(counts), now_s).is_some());
        }
        speed.command(&PerTrack::both(commanded));
        let taken = [0.0, 0.02, 0.04].map(|later_s| {
            let [left, right] = metres.map(|metres| counts(metres + commanded * later_s));
            let now_s = 3.0 + outage_s + later_s;
            speed.update_on_arrival(PerTrack::new(left, right), now_s).is_some()
        });
        (speed, taken)
    }

    /// At 1.875 m/s a track can run from 0.9 m to zero in 0.43 s.
    #[test]
    fn counters_that_were_reset_in_an_outage_are_no_motion() {
        for outage_s in [0.15, 0.45, 1.0, 5.0] {
            for (metres, commanded) in [([0.0; 2], 0.3), ([0.02, 0.03], 0.3), ([0.0; 2], 0.0)] {
                let (speed, taken) = after_outage(outage_s, commanded, metres);
                assert_eq!(taken, [false, false, true], "{outage_s} s, {metres:?} m");
                assert_eq!(speed.faults(), Faults::ENCODER);
            }
        }
    }

    /// A base that drove on, braked, sways, or was pushed where its counters are far from zero.
    #[test]
    fn motion_in_an_outage_is_no_reset() {
        for (outage_s, metres) in [
            (0.45, [1.03, 1.03]),
            (0.45, [0.94, 0.94]),
            (0.45, [0.88, 0.88]),
            (2.0, [1.6, 1.4]),
            (2.0, [0.5, 0.3]),
        ] {
            for commanded in [0.3, 0.0] {
                let (speed, taken) = after_outage(outage_s, commanded, metres);
                assert_eq!((taken, speed.faults()), ([true; 3], Faults::NONE), "{metres:?} m");
            }
        }
    }

    /// It was commanded to reverse before the outage, and reached its start.
    #[test]
    fn commanded_return_to_the_start_is_no_reset() {
        let mut speed = encoder_speed();
        assert!(speed.update(PerTrack::both(9000), 0.0).is_some());
        speed.command(&PerTrack::both(-0.8));
        assert!(speed.update(PerTrack::both(1000), 1.0).is_some());
        assert_eq!(speed.faults(), Faults::NONE);
    }

    /// A base at 1 m/s is asked every 20 ms. The answers wait for a host that is busy for 0.3 s, and arrive together.
    #[test]
    fn answers_that_arrive_together_are_no_fault() {
        let mut speed = encoder_speed();
        let counts = |measured_s: f64| PerTrack::both((10_000.0 * measured_s) as u32);
        for step in 0..10 {
            let now_s = 0.02 * f64::from(step);
            assert!(speed.update_on_arrival(counts(now_s), now_s).is_some());
        }
        for (measured_s, arrived_s) in [(0.20, 0.50), (0.50, 0.51), (0.52, 0.53), (0.54, 0.55)] {
            let speeds = speed.update_on_arrival(counts(measured_s), arrived_s).expect("plausible");
            assert!((0.0..1.5).contains(&speeds.left), "{speeds:?}");
        }
        assert_eq!((speed.rejected(), speed.faults()), (0, Faults::NONE));
        // A counter that has jumped is still a fault.
        let jumped = (1..=3).map(|step| {
            speed.update_on_arrival(PerTrack::both(0), 0.55 + 0.02 * f64::from(step)).is_some()
        });
        assert_eq!(jumped.collect::<Vec<_>>(), [false, false, true]);
        assert_eq!(speed.faults(), Faults::ENCODER);
    }
}
