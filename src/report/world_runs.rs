//! Runs through benchmark worlds, of either benchmark, as the chart by world takes them.

use std::collections::BTreeMap;

use super::number::fixed;
use crate::experiment::barn::OverWorlds;
use crate::experiment::{ContactCause, Group, RunOutcome, RunRow};

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum End {
    Arrived,
    /// The robot closed the gap.
    DroveInto,
    /// It was run into, and could have stayed clear.
    Avoidable,
    /// It was run into, and could not.
    RunInto,
    /// It gave up, or the time was up.
    Stopped,
}

/// One run.
pub(super) struct Run {
    pub(super) end: End,
    /// Simulated time, seconds.
    pub(super) time_s: f64,
    /// The same in the unit of the chart.
    pub(super) drawn: f64,
    pub(super) score: f64,
}

/// The runs of one world.
pub(super) struct World {
    pub(super) number: u32,
    pub(super) runs: Vec<Run>,
}

/// A benchmark's worlds and what its chart says about them.
pub(super) struct Worlds {
    pub(super) title: &'static str,
    /// Title of the axis of times.
    pub(super) times: &'static str,
    /// A value on it that means something.
    pub(super) level: Option<(f64, &'static str)>,
    /// What came of all, and how to read the chart.
    pub(super) caption: String,
    pub(super) has_scores: bool,
    /// From the easiest to the hardest: by the share of runs that did not arrive, then by the median time of the others.
    pub(super) ranked: Vec<World>,
}

const fn end(row: &RunRow) -> End {
    match (row.outcome, row.contact_cause) {
        (RunOutcome::Reached, _) => End::Arrived,
        (RunOutcome::Contact, Some(ContactCause::Avoidable)) => End::Avoidable,
        (RunOutcome::Contact, Some(ContactCause::Other)) => End::RunInto,
        (RunOutcome::Contact, _) => End::DroveInto,
        (RunOutcome::Timeout | RunOutcome::Failed | RunOutcome::Error, _) => End::Stopped,
    }
}

/// Score and time over the optimal time: what `OT / clip(T, 2 OT, 8 OT)` looks at.
pub(super) fn of_barn(rows: &[RunRow]) -> Worlds {
    let all: Vec<&RunRow> = rows.iter().collect();
    let (all, means) = (Group::of("", &all), OverWorlds::of(&all));
    let runs = rows.iter().map(|row| {
        let run = Run {
            end: end(row),
            time_s: row.time_s,
            drawn: row.time_s / row.optimal_time_s.unwrap_or(f64::NAN),
            score: row.score.unwrap_or(f64::NAN),
        };
        (row.world.parse().unwrap_or_default(), run)
    });
    Worlds {
        title: "BARN by world",
        times: "Time over the optimal, runs that arrived (logarithmic)",
        level: Some((2.0, "up to here the full score")),
        caption: format!(
            "{} worlds, {} runs: success {}, {} collided, score {} of 0.5. The score of a run is OT / clip(T, 2 OT, 8 OT) \
             if it arrived, else 0; OT is what the benchmark's path takes at 2 m/s. {READING}",
            all.worlds,
            all.runs,
            fixed(means.success, 3),
            all.contacts,
            fixed(means.score, 4),
        ),
        has_scores: true,
        ranked: from_the_easiest(runs),
    }
}

/// Time and whose the contacts were.
pub(super) fn of_dynabarn(rows: &[RunRow]) -> Worlds {
    let all = Group::of("", &rows.iter().collect::<Vec<_>>());
    let runs = rows.iter().map(|row| {
        let run = Run {
            end: end(row),
            time_s: row.time_s,
            drawn: row.time_s,
            score: f64::NAN,
        };
        (row.world.parse().unwrap_or_default(), run)
    });
    Worlds {
        title: "DynaBARN by world",
        times: "Time of the runs that arrived, s (logarithmic)",
        level: None,
        caption: format!(
            "{} worlds, {} runs: success {}, every contact a failure; {} contacts. A contact is the robot's if it closed \
             the gap itself, and avoidable if a steady command from 2.5 s before would have kept it clear. {READING}",
            all.worlds,
            all.runs,
            fixed(all.reached_share, 3),
            all.contacts,
        ),
        has_scores: false,
        ranked: from_the_easiest(runs),
    }
}

const READING: &str = "Worlds stand from the easiest on: by the share of runs that did not arrive, then by the median time. \
    A dot is the median of a world's runs that arrived, its line reaches from the fastest to the slowest.";

fn from_the_easiest(runs: impl Iterator<Item = (u32, Run)>) -> Vec<World> {
    let mut by_number: BTreeMap<u32, Vec<Run>> = BTreeMap::new();
    for (number, run) in runs {
        by_number.entry(number).or_default().push(run);
    }
    let worlds = by_number.into_iter();
    let mut worlds: Vec<World> = worlds
        .map(|(number, runs)| World { number, runs })
        .collect();
    // Worlds that nobody arrived in have no median, and are the hardest.
    let middle = |world: &World| {
        world
            .spread()
            .map_or(f64::INFINITY, |[_, middle, _]| middle)
    };
    worlds.sort_by(|a, b| {
        let missed = a.missed_share().total_cmp(&b.missed_share());
        missed.then(middle(a).total_cmp(&middle(b)))
    });
    worlds
}

impl World {
    pub(super) fn count(&self, end: End) -> usize {
        self.runs.iter().filter(|run| run.end == end).count()
    }

    fn missed_share(&self) -> f64 {
        1.0 - self.count(End::Arrived) as f64 / self.runs.len() as f64
    }

    /// Least, median and greatest of the values drawn, over the runs that arrived; none where none did, or a value cannot
    /// be shown.
    pub(super) fn spread(&self) -> Option<[f64; 3]> {
        spread(self.arrived().map(|run| run.drawn))
    }

    /// The same of the times, seconds.
    pub(super) fn spread_s(&self) -> Option<[f64; 3]> {
        spread(self.arrived().map(|run| run.time_s))
    }

    fn arrived(&self) -> impl Iterator<Item = &Run> {
        self.runs.iter().filter(|run| run.end == End::Arrived)
    }

    pub(super) fn mean_score(&self) -> f64 {
        self.runs.iter().map(|run| run.score).sum::<f64>() / self.runs.len() as f64
    }
}

fn spread(values: impl Iterator<Item = f64>) -> Option<[f64; 3]> {
    let mut values: Vec<f64> = values
        .filter(|value| value.is_finite() && *value > 0.0)
        .collect();
    values.sort_by(f64::total_cmp);
    let (first, last) = (values.first()?, values.last()?);
    let middle = f64::midpoint(values[(values.len() - 1) / 2], values[values.len() / 2]);
    Some([*first, middle, *last])
}
