//! All runs together.

use std::collections::BTreeSet;

use serde::Serialize;

use super::{Culprit, DynaBarnRow};
use crate::experiment::missions::mean;
use crate::experiment::worlds::Verdict;

/// What came of runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Summary {
    /// Worlds.
    pub worlds: usize,
    /// Runs.
    pub runs: usize,
    /// Runs that reached the goal.
    pub succeeded: usize,
    /// Share of all runs that reached the goal, 0 to 1: every contact is a failure, whoever's it was.
    pub success: f64,
    /// The same share of the runs that did not end in a contact that was neither the robot's nor avoidable; none where
    /// there is no such run.
    pub success_attributed: Option<f64>,
    /// Runs that ended in a contact.
    pub collided: usize,
    /// Contacts that the robot drove into.
    pub by_robot: usize,
    /// Contacts that it did not drive into, but could have avoided.
    pub avoidable: usize,
    /// The other contacts.
    pub other: usize,
    /// Runs that ran out of time.
    pub timeout: usize,
    /// Runs that were given up with a reason.
    pub failed: usize,
    /// Time of the runs that reached the goal, seconds, the mean; none where none did.
    pub mean_time_s: Option<f64>,
}

impl Summary {
    /// The summary of rows.
    #[must_use]
    pub fn of(rows: &[&DynaBarnRow]) -> Self {
        let ended = |verdict| rows.iter().filter(|row| row.result == verdict).count();
        let blamed = |culprit| rows.iter().filter(|row| row.blame == culprit).count();
        let (succeeded, other) = (ended(Verdict::Succeeded), blamed(Culprit::Other));
        let share = |of: usize| (of > 0).then(|| succeeded as f64 / of as f64);
        let reached = rows.iter().filter(|row| row.result == Verdict::Succeeded);
        let worlds: BTreeSet<u32> = rows.iter().map(|row| row.world).collect();
        Self {
            worlds: worlds.len(),
            runs: rows.len(),
            succeeded,
            success: share(rows.len()).unwrap_or_default(),
            success_attributed: share(rows.len() - other),
            collided: ended(Verdict::Collided),
            by_robot: blamed(Culprit::Robot),
            avoidable: blamed(Culprit::Avoidable),
            other,
            timeout: ended(Verdict::Timeout),
            failed: ended(Verdict::Failed),
            mean_time_s: mean(reached.map(|row| row.time_s)),
        }
    }
}
