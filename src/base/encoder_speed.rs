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
        }
    }

    /// Takes the counts of both tracks at a time by the base's clock, seconds, and returns their speeds. Returns none if no track
    /// can have run that far since the last reading, or if time ran backwards. The third consecutive rejected reading that agrees
    /// with the others restarts the measurement and sets [`Faults::ENCODER`].
    pub(super) fn update(&mut self, counts: PerTrack<u32>, time_s: f64) -> Option<TrackSpeeds> {
        self.take(Reading { counts, time_s, earliest_s: time_s })
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
        self.take(Reading { counts, time_s: arrived_s, earliest_s })
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
        if elapsed_s <= 0.0 {
            return Some(TrackSpeeds::default());
        }
        let travelled_m = travel_m(&first.counts, &counts, &self.ticks_per_m);
        Some(travelled_m.map(|travelled_m| travelled_m / elapsed_s))
    }

    /// Whether the tracks can have run from one reading to the next.
    fn is_plausible(&self, before: &Reading, now: &Reading) -> bool {
        let travelled_m = travel_m(&before.counts, &now.counts, &self.ticks_per_m);
        is_plausible_travel(&travelled_m, now.time_s - before.earliest_s, self.max_speed_m_s)
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
    let farther_m = travelled_m.left.abs().max(travelled_m.right.abs());
    elapsed_s >= 0.0 && farther_m <= max_speed_m_s * (elapsed_s + JITTER_S)
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
