//! The decision times of a mission, paired with its ticks.

use super::MissionView;
use super::number::significant;
use crate::bench::{Latencies, LatencySummary};

/// The least latency that a logarithmic axis shows, milliseconds: below the resolution of any clock here.
const LEAST_MS: f64 = 1e-5;

/// The decisions of a mission that were timed, at least one.
pub(super) struct Latency {
    /// When each was taken, in seconds, and how long it took, in milliseconds, above zero.
    pub(super) ticks: Vec<(f64, f64)>,
    /// Entries that are no time, or that belong to no tick.
    pub(super) left_out: usize,
    /// Deadline of a decision, milliseconds; none where the mission states no control period.
    pub(super) deadline_ms: Option<f64>,
    pub(super) summary: LatencySummary,
    latencies: Latencies,
}

impl Latency {
    /// Of a mission; none where no decision was timed.
    pub(super) fn of(mission: &MissionView) -> Option<Self> {
        let mut latencies = Latencies::default();
        let ticks: Vec<(f64, f64)> = mission
            .trace
            .rows
            .iter()
            .zip(mission.latency_ms)
            .filter(|(row, ms)| row.time_s.is_finite() && latencies.record(*ms / 1e3).is_ok())
            .map(|(row, ms)| (row.time_s, ms.max(LEAST_MS)))
            .collect();
        let deadline_ms = mission.control_period_s * 1e3;
        Some(Self {
            left_out: mission.latency_ms.len() - ticks.len(),
            deadline_ms: (deadline_ms.is_finite() && deadline_ms > 0.0).then_some(deadline_ms),
            summary: latencies.summary()?,
            ticks,
            latencies,
        })
    }

    /// The fastest decision, milliseconds.
    pub(super) fn least_ms(&self) -> f64 {
        self.ticks
            .iter()
            .map(|&(_, ms)| ms)
            .fold(self.slowest_ms(), f64::min)
    }

    /// The slowest decision, milliseconds.
    pub(super) fn slowest_ms(&self) -> f64 {
        self.summary.max_ms.max(LEAST_MS)
    }

    /// The latency that a share of the decisions, 0..=1, does not exceed, milliseconds.
    pub(super) fn quantile_ms(&self, share: f64) -> f64 {
        self.latencies.quantile_ms(share).unwrap_or(f64::NAN)
    }

    pub(super) fn in_words(&self) -> String {
        format!(
            "Half of {} decisions took at most {} ms, 99 % at most {} ms, the slowest {} ms.",
            self.summary.count,
            significant(self.summary.p50_ms),
            significant(self.summary.p99_ms),
            significant(self.summary.max_ms)
        )
    }
}
