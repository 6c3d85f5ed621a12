//! What a node has met.

use std::collections::BTreeMap;

use serde::Serialize;

use super::Topic;

/// Counts since the start.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Tally {
    /// Messages taken, by topic.
    pub received: BTreeMap<&'static str, u64>,
    /// Messages refused, by topic.
    pub refused: BTreeMap<&'static str, u64>,
    /// Goals that were begun.
    pub goals: u64,
    /// Goals that the robot stood at.
    pub reached: u64,
    /// Goals that it gave up, or that no path led to.
    pub given_up: u64,
    /// Velocities to publish.
    pub commands: u64,
}

impl Tally {
    pub(super) fn took(&mut self, topic: Topic) {
        *self.received.entry(topic.name()).or_default() += 1;
    }

    pub(super) fn refused(&mut self, topic: Topic) {
        *self.refused.entry(topic.name()).or_default() += 1;
    }
}
