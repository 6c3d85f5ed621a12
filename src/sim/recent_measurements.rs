//! Measurements that arrive late by a fault.

use std::collections::VecDeque;

use super::FaultInjection;
use super::fault_injection::active_faults;

/// The recent measurements of a sensor whose measurements arrive late.
#[derive(Clone, Debug)]
pub(super) struct RecentMeasurements<T> {
    /// Each with its time, seconds.
    kept: VecDeque<(f64, T)>,
}

impl<T> Default for RecentMeasurements<T> {
    fn default() -> Self {
        Self { kept: VecDeque::new() }
    }
}

impl<T: Clone> RecentMeasurements<T> {
    /// Takes the measurement of a time, seconds, which must ascend from call to call, and returns the one that arrives then. A
    /// function has the delay of a fault, seconds; the longest delay of the present faults counts. None without one.
    pub fn arriving(
        &mut self,
        faults: &[FaultInjection],
        time_s: f64,
        late_s: impl Fn(&FaultInjection) -> Option<f64>,
        measured: impl FnOnce() -> T,
    ) -> Option<T> {
        let keep_s = faults.iter().filter_map(&late_s).reduce(f64::max)?;
        self.kept.push_back((time_s, measured()));
        while self.kept.get(1).is_some_and(|(next_s, _)| time_s - next_s >= keep_s) {
            self.kept.pop_front();
        }
        let late_s = active_faults(faults, time_s).filter_map(late_s).reduce(f64::max)?;
        let is_due = |(at_s, _): &&(f64, T)| time_s - at_s >= late_s;
        let arrived = self.kept.iter().rev().find(is_due).or_else(|| self.kept.front());
        arrived.map(|(_, measured)| measured.clone())
    }
}
