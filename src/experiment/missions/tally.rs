//! What came of missions, counted.

use std::collections::BTreeMap;

use serde::Serialize;

use super::{Ending, MissionRow, Touch};

/// What came of missions.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Tally {
    /// Missions.
    pub missions: usize,
    /// Those that reached their goal.
    pub reached: usize,
    /// Their share, 0 to 1; zero of no missions.
    pub reached_share: f64,
    /// Contacts that the robot's own motion brought about.
    pub contacts_robot: usize,
    /// Contacts that only the other one's motion brought about.
    pub contacts_other: usize,
    /// Missions that were given up.
    pub failed: usize,
    /// Missions that ran out of time.
    pub timeouts: usize,
    /// Missions by the word of their fault.
    pub faults: BTreeMap<String, usize>,
    /// Unreached goals without a reason.
    pub unexplained: usize,
    /// Mean time of those that reached their goal, seconds.
    pub mean_time_s: Option<f64>,
    /// Mean of their smallest gaps, metres.
    pub mean_clearance_m: Option<f64>,
}

impl Tally {
    /// The tally of rows.
    #[must_use]
    pub fn of(rows: &[&MissionRow]) -> Self {
        let ended = |ending| count(rows, |row| row.result == ending);
        let reached: Vec<&MissionRow> = rows
            .iter()
            .copied()
            .filter(|row| row.result == Ending::Reached)
            .collect();
        let mut faults = BTreeMap::new();
        for fault in rows.iter().filter_map(|row| row.fault.as_ref()) {
            *faults.entry(fault.clone()).or_insert(0) += 1;
        }
        Self {
            missions: rows.len(),
            reached: reached.len(),
            reached_share: reached.len() as f64 / rows.len().max(1) as f64,
            contacts_robot: count(rows, |row| row.contact == Touch::Robot),
            contacts_other: count(rows, |row| row.contact == Touch::Other),
            failed: ended(Ending::Failed),
            timeouts: ended(Ending::Timeout),
            faults,
            unexplained: count(rows, |row| {
                row.result != Ending::Reached && row.reason.as_ref().is_none_or(String::is_empty)
            }),
            mean_time_s: mean(reached.iter().map(|row| row.time_s)),
            mean_clearance_m: mean(reached.iter().filter_map(|row| row.min_clearance_m)),
        }
    }
}

fn count(rows: &[&MissionRow], is: impl Fn(&MissionRow) -> bool) -> usize {
    rows.iter().filter(|row| is(row)).count()
}

/// The mean of values, none of none.
pub(in crate::experiment) fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0), |(sum, count), value| (sum + value, count + 1));
    (count > 0).then(|| sum / f64::from(count))
}
