//! What happened to a GPU on the way.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::local::LossKind;

/// So many incidents are kept in words; of all others only the counts.
const MOST_TOLD: usize = 64;

/// One thing that happened.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Incident {
    /// At which decision, the first is 1; 0 is before it.
    pub decision: u64,
    /// What failed; none where a GPU was opened anew.
    pub kind: Option<LossKind>,
    /// One sentence for people.
    pub what: String,
}

/// Counts of what happened, and the first of it in words.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Incidents {
    /// Decisions taken.
    pub decisions: u64,
    /// Those of them that the CPU took.
    pub on_cpu: u64,
    /// How often the GPU failed, by kind.
    pub losses: BTreeMap<LossKind, u64>,
    /// How often it was opened anew.
    pub reopened: u64,
    /// How often it could not be.
    pub not_reopened: u64,
    /// The first 64 incidents, in order.
    pub told: Vec<Incident>,
}

impl Incidents {
    /// How often the GPU failed.
    #[must_use]
    pub fn lost_in_all(&self) -> u64 {
        self.losses.values().sum()
    }

    /// How many incidents there were: those told in words, and all after them.
    #[must_use]
    pub fn in_all(&self) -> u64 {
        self.lost_in_all() + self.reopened + self.not_reopened
    }

    pub(super) fn lost(&mut self, kind: LossKind, what: String) {
        *self.losses.entry(kind).or_default() += 1;
        self.tell(Some(kind), what);
    }

    pub(super) fn reopened(&mut self, name: &str) {
        self.reopened += 1;
        self.tell(None, format!("{name} opened anew"));
    }

    pub(super) fn not_reopened(&mut self, kind: LossKind, what: String) {
        self.not_reopened += 1;
        self.tell(Some(kind), what);
    }

    fn tell(&mut self, kind: Option<LossKind>, what: String) {
        if self.told.len() < MOST_TOLD {
            self.told.push(Incident {
                decision: self.decisions,
                kind,
                what,
            });
        }
    }
}
