//! What happened to a GPU on the way.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::local::GpuFailureKind;

/// So many incidents are kept in words; of all others only the counts.
const MAX_MESSAGES: usize = 64;

/// One thing that happened.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Incident {
    /// At which decision, the first is 1; 0 is before it.
    pub decision: u64,
    /// What failed; none where a GPU was opened anew.
    pub kind: Option<GpuFailureKind>,
    /// One sentence for people.
    pub message: String,
}

/// Counts of what happened, and the first of it in words.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Incidents {
    /// Decisions taken.
    pub decisions: u64,
    /// Those of them that the CPU took.
    pub on_cpu: u64,
    /// How often the GPU failed, by kind.
    pub failures: BTreeMap<GpuFailureKind, u64>,
    /// How often it was opened anew.
    pub reopened: u64,
    /// How often it could not be.
    pub reopen_failures: u64,
    /// The first 64 incidents, in order.
    pub messages: Vec<Incident>,
}

impl Incidents {
    /// How often the GPU failed.
    #[must_use]
    pub fn total_failures(&self) -> u64 {
        self.failures.values().sum()
    }

    /// How many incidents there were: those told in words, and all after them.
    #[must_use]
    pub fn in_all(&self) -> u64 {
        self.total_failures() + self.reopened + self.reopen_failures
    }

    pub(super) fn lost(&mut self, kind: GpuFailureKind, message: String) {
        *self.failures.entry(kind).or_default() += 1;
        self.tell(Some(kind), message);
    }

    pub(super) fn reopened(&mut self, name: &str) {
        self.reopened += 1;
        self.tell(None, format!("{name} opened anew"));
    }

    pub(super) fn reopen_failures(&mut self, kind: GpuFailureKind, message: String) {
        self.reopen_failures += 1;
        self.tell(Some(kind), message);
    }

    fn tell(&mut self, kind: Option<GpuFailureKind>, message: String) {
        if self.messages.len() < MAX_MESSAGES {
            self.messages.push(Incident {
                decision: self.decisions,
                kind,
                message,
            });
        }
    }
}
