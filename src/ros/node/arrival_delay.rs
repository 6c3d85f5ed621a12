//! The time from stamp to arrival of a stream of messages: transport, and the offset between two clocks.

use std::collections::VecDeque;

/// Time over which the least delay counts, seconds.
const WINDOW_S: f64 = 10.0;
/// Largest number of candidates.
const MAX_CANDIDATES: usize = 256;

/// The least delay of a stream over the last seconds.
///
/// One stream cannot tell a slow transport from a clock that is behind. A negative delay proves that the sender's clock is
/// ahead, by at least this.
#[derive(Clone, Debug, Default)]
pub struct ArrivalDelay {
    /// Times of arrival with their delays, seconds. Delays increase: an earlier and larger one can never be the least.
    candidates: VecDeque<(f64, f64)>,
    /// Arrival and stamp of the last message, seconds.
    last: Option<(f64, f64)>,
    /// The least time between two stamps, seconds: the sender's period.
    period_s: Option<f64>,
}

impl ArrivalDelay {
    /// Records a message with a stamp that arrived at a time, both in seconds.
    pub fn record(&mut self, arrived_s: f64, stamp_s: f64) {
        let delay_s = arrived_s - stamp_s;
        // An arrival in the future means that the node's own clock was set.
        let is_recent =
            |&(then_s, _): &(f64, f64)| (0.0..=WINDOW_S).contains(&(arrived_s - then_s));
        while self.candidates.front().is_some_and(|front| !is_recent(front)) {
            self.candidates.pop_front();
        }
        while self.candidates.back().is_some_and(|(_, back_s)| *back_s >= delay_s) {
            self.candidates.pop_back();
        }
        if self.candidates.len() < MAX_CANDIDATES {
            self.candidates.push_back((arrived_s, delay_s));
        }
        let since_s =
            self.last.map(|(_, last_s)| stamp_s - last_s).filter(|since_s| *since_s > 0.0);
        self.period_s = since_s
            .map(|since_s| self.period_s.map_or(since_s, |least_s| least_s.min(since_s)))
            .or(self.period_s);
        self.last = Some((arrived_s, stamp_s));
    }

    /// Whether the last message arrived at most this time ago, seconds.
    #[must_use]
    pub fn is_recent(&self, now_s: f64, limit_s: f64) -> bool {
        self.last.is_some_and(|(arrived_s, _)| now_s - arrived_s <= limit_s)
    }

    /// The least age of the newest message just before the next one arrives, seconds; none before the first message.
    #[must_use]
    pub fn least_age_s(&self) -> Option<f64> {
        Some(self.least_s()? + self.period_s.unwrap_or_default())
    }

    /// The least delay, seconds; none before the first message.
    #[must_use]
    pub fn least_s(&self) -> Option<f64> {
        self.candidates.front().map(|(_, delay_s)| *delay_s)
    }

    /// By how much the sender's clock is ahead at least, seconds.
    #[must_use]
    pub fn ahead_s(&self) -> f64 {
        (-self.least_s().unwrap_or_default()).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn least_delay_is_that_of_the_window() {
        let mut delay = ArrivalDelay::default();
        assert_eq!((delay.least_s(), delay.ahead_s()), (None, 0.0));
        for tick in 0..400 {
            let stamp_s = 100.0 + 0.05 * f64::from(tick);
            // One fast message at 5 s.
            let delay_s = if tick == 100 { 0.01 } else { 0.04 };
            delay.record(stamp_s + delay_s, stamp_s);
            let expected_s = if (100..300).contains(&tick) { 0.01 } else { 0.04 };
            let least_s = delay.least_s().expect("a message");
            assert!((least_s - expected_s).abs() < 1e-9, "{tick}: {least_s}");
        }
    }

    #[test]
    fn slow_transport_is_no_clock_that_is_ahead() {
        let mut delay = ArrivalDelay::default();
        delay.record(100.04, 100.0);
        assert!((delay.least_s().expect("a message") - 0.04).abs() < 1e-9);
        assert_eq!(delay.ahead_s(), 0.0);
    }

    #[test]
    fn message_ages_until_the_next_one() {
        let mut delay = ArrivalDelay::default();
        for (stamp_s, least_age_s) in [(100.0, 0.25), (100.1, 0.35), (100.6, 0.35)] {
            delay.record(stamp_s + 0.25, stamp_s);
            let found_s = delay.least_age_s().expect("a message");
            assert!((found_s - least_age_s).abs() < 1e-9, "{stamp_s}: {found_s}");
        }
        assert!(delay.is_recent(101.1, 0.3) && !delay.is_recent(101.2, 0.3));
    }

    /// Delays from before the node's own clock was set back do not count.
    #[test]
    fn delays_from_the_future_are_forgotten() {
        let mut delay = ArrivalDelay::default();
        delay.record(100.01, 100.0);
        delay.record(50.04, 50.0);
        assert!((delay.least_s().expect("a message") - 0.04).abs() < 1e-9);
    }

    #[test]
    fn clock_ahead_shows_as_negative_delay_and_memory_is_bounded() {
        let mut delay = ArrivalDelay::default();
        for tick in 0..10_000 {
            let arrived_s = 100.0 + 1e-4 * f64::from(tick);
            delay.record(arrived_s, arrived_s + 0.2 - 1e-6 * f64::from(tick));
        }
        assert!((delay.ahead_s() - 0.2).abs() < 1e-9, "{}", delay.ahead_s());
        assert!(delay.candidates.len() <= MAX_CANDIDATES);
    }
}
