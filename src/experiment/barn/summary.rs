//! Figures over all BARN runs.

use serde::Serialize;

use super::{BarnWorld, Published};
use crate::experiment::group::{by_world, mean};
use crate::experiment::{Group, RunRow};

/// Figures of all runs, and those of the worlds with published figures next to the published ones.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct BarnSummary {
    /// All runs.
    pub all: Group,
    /// The same as means over worlds.
    pub over_worlds: OverWorlds,
    /// Means over the worlds with published figures; none if no world has any.
    pub official: Option<OverWorlds>,
    /// The published figures of the same worlds, means over worlds.
    pub published: Option<PublishedMeans>,
}

/// Means over the runs of each world and then over worlds: each world counts the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct OverWorlds {
    /// Number of worlds.
    pub worlds: usize,
    /// Number of runs.
    pub runs: usize,
    /// Share of runs that reached the goal, 0 to 1.
    pub success: f64,
    /// Score, 0 to 0.5.
    pub score: f64,
}

/// Figures of the challenge's baseline, measured in Gazebo.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct PublishedMeans {
    /// Number of worlds.
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

impl BarnSummary {
    /// The summary of rows whose worlds are all among those given.
    #[must_use]
    pub fn of(rows: &[RunRow], worlds: &[BarnWorld]) -> Self {
        let figures: Vec<(String, Published)> = worlds
            .iter()
            .filter(|world| world.official)
            .filter_map(|world| Some((world.number.to_string(), world.published?)))
            .filter(|(world, _)| rows.iter().any(|row| row.world == *world))
            .collect();
        let is_official = |row: &&RunRow| figures.iter().any(|(world, _)| *world == row.world);
        let official: Vec<&RunRow> = rows.iter().filter(is_official).collect();
        Self {
            all: Group::of("all", rows),
            over_worlds: OverWorlds::of(rows),
            official: (!official.is_empty()).then(|| OverWorlds::of(official)),
            published: (!figures.is_empty()).then(|| published(&figures)),
        }
    }
}

impl OverWorlds {
    /// The means of rows.
    #[must_use]
    pub fn of<'r>(rows: impl IntoIterator<Item = &'r RunRow>) -> Self {
        let by_world = by_world(rows);
        let over_worlds = |figure: fn(&RunRow) -> f64| {
            let of_world =
                |(_, rows): &(&str, Vec<&RunRow>)| mean(rows.iter().map(|row| figure(row)));
            mean(by_world.iter().filter_map(of_world)).unwrap_or_default()
        };
        Self {
            worlds: by_world.len(),
            runs: by_world.iter().map(|(_, rows)| rows.len()).sum(),
            success: over_worlds(|row| f64::from(u8::from(row.reached()))),
            score: over_worlds(|row| row.score.unwrap_or_default()),
        }
    }
}

fn published(figures: &[(String, Published)]) -> PublishedMeans {
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
