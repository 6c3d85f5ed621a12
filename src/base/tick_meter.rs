//! From encoder readings to track speeds, and a gate against readings that no track can make.

use std::collections::VecDeque;

use super::{BaseSettings, Faults};
use crate::robot::{PerTrack, TrackSpeeds, travel_m};

/// Speeds are means over so long, seconds: three readings at 30 Hz, so that neither a tick more or less nor a late byte
/// makes much of a difference.
const WINDOW_S: f64 = 0.1;

/// A track may be so many times faster than its highest speed: downhill, or by a setting that is somewhat off.
const MARGIN: f64 = 1.5;

/// Readings may be early or late by so much, seconds: a USB adapter holds bytes back for up to 16 ms, and a busy host
/// longer.
const JITTER_S: f64 = 0.05;

/// So many refused readings that agree with one another are no damaged bytes but a counter that is elsewhere now.
const ALIKE_IN_A_ROW: u32 = 3;

/// A reading of both counters and its time, seconds.
type Reading = (f64, PerTrack<u32>);

/// The readings of the last moments.
#[derive(Clone, Debug)]
pub(super) struct TickMeter {
    ticks_per_m: PerTrack<f64>,
    most_m_s: f64,
    readings: VecDeque<Reading>,
    /// The last reading, if it was refused, and how many before it agree with it, itself counted.
    refused: Option<(Reading, u32)>,
    refusals: u64,
    faulty: bool,
}

impl TickMeter {
    pub(super) fn new(settings: &BaseSettings) -> Self {
        Self {
            ticks_per_m: settings.ticks_per_m,
            most_m_s: highest_m_s(settings),
            readings: VecDeque::new(),
            refused: None,
            refusals: 0,
            faulty: false,
        }
    }

    /// Takes a reading of the tracks at a time in seconds, and returns their speeds, or none where no track can have run
    /// so far since the last, or time ran backwards. The third in a row of such readings that agree with one another is
    /// believed, as a fresh start and a fault.
    pub(super) fn read(&mut self, ticks: PerTrack<u32>, time_s: f64) -> Option<TrackSpeeds> {
        let reading = (time_s, ticks);
        if self
            .readings
            .back()
            .is_some_and(|last| !self.can_follow(last, &reading))
        {
            self.refusals += 1;
            let alike = match &self.refused {
                Some((last, alike)) if self.can_follow(last, &reading) => alike + 1,
                _ => 1,
            };
            if alike < ALIKE_IN_A_ROW {
                self.refused = Some((reading, alike));
                return None;
            }
            self.faulty = true;
            self.readings.clear();
        }
        self.refused = None;
        // The clock of a base may stand still, or its reports come twice: one reading of a time is enough, or they would
        // never leave the window.
        if self.readings.len() > 1 && self.readings.back().is_some_and(|last| last.0 == time_s) {
            self.readings.pop_back();
        }
        self.readings.push_back(reading);
        while self.readings.len() > 2 && time_s - self.readings[1].0 >= WINDOW_S {
            self.readings.pop_front();
        }
        let (first_s, first) = self.readings[0];
        let elapsed_s = time_s - first_s;
        if elapsed_s <= 0.0 {
            return Some(TrackSpeeds::default());
        }
        let ran_m = travel_m(&first, &ticks, &self.ticks_per_m);
        Some(ran_m.map(|ran_m| ran_m / elapsed_s).into())
    }

    /// Whether tracks can run from one reading to another.
    fn can_follow(&self, before: &Reading, now: &Reading) -> bool {
        let ran_m = travel_m(&before.1, &now.1, &self.ticks_per_m);
        can_run(&ran_m, now.0 - before.0, self.most_m_s)
    }

    /// Readings refused so far.
    pub(super) const fn refused(&self) -> u64 {
        self.refusals
    }

    /// The fault of a counter that jumped, until it is forgotten.
    pub(super) const fn faults(&self) -> Faults {
        Faults::ENCODER.only_if(self.faulty)
    }

    /// Forgets the fault.
    pub(super) fn release(&mut self) {
        self.faulty = false;
    }
}

/// Whether tracks can run a way in a time, seconds, at a highest speed as [`highest_m_s`] has it.
pub(super) fn can_run(ran_m: &PerTrack<f64>, elapsed_s: f64, most_m_s: f64) -> bool {
    let farthest_m = ran_m.left.abs().max(ran_m.right.abs());
    elapsed_s >= 0.0 && farthest_m <= most_m_s * (elapsed_s + JITTER_S)
}

/// Speed beyond which no track runs, m/s.
pub(super) fn highest_m_s(settings: &BaseSettings) -> f64 {
    MARGIN * settings.tracks.max_track_speed
}

#[cfg(test)]
mod tests {
    use super::*;

    fn meter() -> TickMeter {
        // 1.25 m/s at most, 10,000 ticks a metre: with all margins 937.5 ticks at once, and 18,750 a second.
        TickMeter::new(&BaseSettings::default())
    }

    #[test]
    fn speeds_are_means_across_the_wrap() {
        let mut meter = meter();
        let start = u32::MAX - 50;
        for tick in 0..20_u32 {
            let ticks = PerTrack::new(
                start.wrapping_add(100 * tick),
                start.wrapping_sub(50 * tick),
            );
            let speeds = meter.read(ticks, 0.02 * f64::from(tick));
            let speeds = speeds.expect("plausible");
            if tick > 0 {
                assert!((speeds.left - 0.5).abs() < 1e-9, "{speeds:?}");
                assert!((speeds.right + 0.25).abs() < 1e-9, "{speeds:?}");
            }
        }
        assert!(meter.readings.len() <= 7, "{}", meter.readings.len());
    }

    #[test]
    fn a_jump_is_refused_and_forgotten() {
        let mut meter = meter();
        meter.read(PerTrack::both(0), 0.0);
        assert_eq!(meter.read(PerTrack::new(100_000, 0), 0.02), None);
        assert!(meter.read(PerTrack::both(200), 0.04).is_some());
        assert_eq!((meter.refused(), meter.faults()), (1, Faults::NONE));
    }

    #[test]
    fn counters_that_begin_anew_are_a_fault_and_no_motion() {
        let mut meter = meter();
        meter.read(PerTrack::both(1_000_000), 0.0);
        assert_eq!(meter.read(PerTrack::both(0), 0.02), None);
        assert_eq!(meter.read(PerTrack::both(10), 0.04), None);
        assert_eq!(
            meter.read(PerTrack::both(20), 0.06),
            Some(TrackSpeeds::default())
        );
        assert_eq!(meter.faults(), Faults::ENCODER);
        meter.release();
        assert_eq!((meter.refused(), meter.faults()), (3, Faults::NONE));
    }

    #[test]
    fn readings_that_agree_with_nothing_are_never_believed() {
        let mut meter = meter();
        meter.read(PerTrack::both(0), 0.0);
        for look in 1..50_u32 {
            let wild = PerTrack::new(look.wrapping_mul(0x9E37_79B9), 0);
            assert_eq!(meter.read(wild, 0.02 * f64::from(look)), None);
        }
        assert_eq!((meter.refused(), meter.faults()), (49, Faults::NONE));
    }

    #[test]
    fn time_that_stands_still_fills_no_memory() {
        let mut meter = meter();
        for tick in 0..1000 {
            assert!(meter.read(PerTrack::both(tick), 3.0).is_some());
        }
        assert_eq!(meter.readings.len(), 2);
        let speeds = meter.read(PerTrack::both(1999), 3.1).expect("plausible");
        assert!((speeds.left - 1.0).abs() < 1e-9, "{speeds:?}");
    }

    #[test]
    fn time_that_runs_backwards_is_refused() {
        let mut meter = meter();
        meter.read(PerTrack::both(0), 5.0);
        assert_eq!(meter.read(PerTrack::both(0), 0.1), None);
    }
}
