//! All runs together.

use std::collections::BTreeMap;

use serde::Serialize;

use super::{BarnRow, BarnWorld, Published};
use crate::experiment::missions::mean;
use crate::experiment::worlds::Verdict;

/// What came of runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Outcome {
    /// Worlds.
    pub worlds: usize,
    /// Runs.
    pub runs: usize,
    /// Share of runs that reached the goal, 0 to 1, the mean over worlds.
    pub success: f64,
    /// Runs that ended in a collision.
    pub collided: usize,
    /// Runs that ran out of time.
    pub timeout: usize,
    /// Runs that were given up with a reason.
    pub failed: usize,
    /// Score, 0 to 0.5, the mean over the runs of each world and then over worlds.
    pub score: f64,
    /// Time of the runs that reached the goal, seconds, the mean; none where none did.
    pub mean_time_s: Option<f64>,
}

/// All worlds, and those of them that have published figures, beside these.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Summary {
    /// All worlds.
    #[serde(flatten)]
    pub all: Outcome,
    /// Those with published figures; none where no world has any.
    pub official: Option<Outcome>,
    /// The published figures of the same worlds, means over worlds.
    pub published: Option<PublishedMeans>,
}

/// What the challenge's baseline did, in Gazebo.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct PublishedMeans {
    /// Worlds.
    pub worlds: usize,
    /// Share of runs that reached the goal.
    pub success: f64,
    /// Share of runs that ended in a collision.
    pub collided: f64,
    /// Share of runs that ran out of time.
    pub timeout: f64,
    /// Score.
    pub score: f64,
}

impl Summary {
    /// The summary of rows, of worlds that are all among those given.
    #[must_use]
    pub fn of(rows: &[&BarnRow], worlds: &[BarnWorld]) -> Self {
        let figures: Vec<(u32, Published)> = worlds
            .iter()
            .filter(|world| world.official)
            .filter_map(|world| Some((world.number, world.published?)))
            .filter(|(world, _)| rows.iter().any(|row| row.world == *world))
            .collect();
        let is_official = |row: &&BarnRow| figures.iter().any(|(world, _)| *world == row.world);
        let official: Vec<&BarnRow> = rows.iter().copied().filter(is_official).collect();
        Self {
            all: outcome(rows),
            official: (!official.is_empty()).then(|| outcome(&official)),
            published: (!figures.is_empty()).then(|| published(&figures)),
        }
    }
}

fn outcome(rows: &[&BarnRow]) -> Outcome {
    let mut by_world: BTreeMap<u32, Vec<&BarnRow>> = BTreeMap::new();
    for row in rows {
        by_world.entry(row.world).or_default().push(row);
    }
    let over_worlds = |figure: &dyn Fn(&BarnRow) -> f64| {
        let of_world = |rows: &Vec<&BarnRow>| mean(rows.iter().map(|row| figure(row)));
        mean(by_world.values().filter_map(of_world)).unwrap_or_default()
    };
    let count = |verdict| rows.iter().filter(|row| row.result == verdict).count();
    let reached = |row: &BarnRow| row.result == Verdict::Succeeded;
    Outcome {
        worlds: by_world.len(),
        runs: rows.len(),
        success: over_worlds(&|row| f64::from(u8::from(reached(row)))),
        collided: count(Verdict::Collided),
        timeout: count(Verdict::Timeout),
        failed: count(Verdict::Failed),
        score: over_worlds(&|row| row.score),
        mean_time_s: mean(rows.iter().filter(|row| reached(row)).map(|row| row.time_s)),
    }
}

fn published(figures: &[(u32, Published)]) -> PublishedMeans {
    let over = |figure: fn(&Published) -> f64| {
        mean(figures.iter().map(|(_, published)| figure(published))).unwrap_or_default()
    };
    PublishedMeans {
        worlds: figures.len(),
        success: over(|it| it.success),
        collided: over(|it| it.collided),
        timeout: over(|it| it.timeout),
        score: over(|it| it.score),
    }
}
