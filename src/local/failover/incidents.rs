//! Records GPU failures and recoveries.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::local::GpuFailureKind;

/// Number of incidents whose messages are kept; the others are only counted.
const MAX_MESSAGES: usize = 64;

/// A GPU failure, or a successful or failed attempt to reopen the GPU.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct Incident {
    /// Number of the decision, from 1; 0 is before the first.
    pub decision: u64,
    /// Kind of failure; `None` when a GPU was reopened.
    pub kind: Option<GpuFailureKind>,
    /// Message, one sentence.
    pub message: String,
}

/// Counts of GPU failures and recoveries, and the first messages.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct Incidents {
    /// Decisions so far.
    pub decisions: u64,
    /// Decisions that the CPU took.
    pub on_cpu: u64,
    /// GPU failures by kind.
    pub failures: BTreeMap<GpuFailureKind, u64>,
    /// Number of times the GPU was reopened.
    pub reopened: u64,
    /// Number of failed attempts to reopen it.
    pub reopen_failures: u64,
    /// The first 64 incidents, in order.
    pub messages: Vec<Incident>,
}

impl Incidents {
    /// Number of GPU failures.
    #[must_use]
    pub fn total_failures(&self) -> u64 {
        self.failures.values().sum()
    }

    /// Number of all incidents, with and without a message.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.total_failures() + self.reopened + self.reopen_failures
    }

    /// Keeps the message of the first incidents.
    pub(super) fn record(&mut self, kind: Option<GpuFailureKind>, message: String) {
        if self.messages.len() < MAX_MESSAGES {
            self.messages.push(Incident { decision: self.decisions, kind, message });
        }
    }
}
