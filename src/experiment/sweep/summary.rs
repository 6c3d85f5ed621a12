//! What came of the cells that differ in world and seed alone.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

use super::{CellResult, SweepRow, WorldKind};
use crate::bench::Columns;
use crate::experiment::missions::mean;

/// All runs with the same settings, weights, sampling and engine through worlds of one kind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SweepGroup {
    /// Kind of the worlds.
    pub kind: WorldKind,
    /// Name of the changes to the settings.
    pub config: Option<String>,
    /// Name of the weights.
    pub weights: Option<String>,
    /// The engine.
    pub engine: String,
    /// Forward speeds.
    pub vx_samples: u32,
    /// Turn rates.
    pub vtheta_samples: u32,
    /// Samples.
    pub samples: u64,
    /// Cells.
    pub runs: usize,
    /// Those that reached their goal.
    pub reached: usize,
    /// Those that ended in contact.
    pub contacts: usize,
    /// Those that ran out of time.
    pub timeouts: usize,
    /// Those that were given up, or could not be begun.
    pub failed: usize,
    /// Mean time of those that reached their goal, seconds.
    pub mean_time_s: Option<f64>,
    /// Mean time over the worlds and seeds that every group of this kind reached, seconds; only these times compare.
    pub mean_shared_time_s: Option<f64>,
    /// How many worlds and seeds those are.
    pub shared: usize,
    /// BARN's mean score, 0 to 0.5.
    pub mean_score: Option<f64>,
    /// Mean of the smallest gaps, metres.
    pub mean_clearance_m: Option<f64>,
}

impl Columns for SweepGroup {
    const COLUMNS: &[&str] = &[
        "kind",
        "config",
        "weights",
        "engine",
        "vx_samples",
        "vtheta_samples",
        "samples",
        "runs",
        "reached",
        "contacts",
        "timeouts",
        "failed",
        "mean_time_s",
        "mean_shared_time_s",
        "shared",
        "mean_score",
        "mean_clearance_m",
    ];
}

/// The groups in the order in which they first occur.
#[must_use]
pub fn groups(rows: &[SweepRow]) -> Vec<SweepGroup> {
    let mut all: Vec<Vec<&SweepRow>> = Vec::new();
    for row in rows {
        match all.iter_mut().find(|group| same(group[0], row)) {
            Some(group) => group.push(row),
            None => all.push(vec![row]),
        }
    }
    let reached: Vec<BTreeSet<Which>> = all.iter().map(|group| reached(group)).collect();
    let shared = |row: &&SweepRow| {
        let peers = all.iter().zip(&reached);
        peers
            .filter(|(group, _)| group[0].label.kind == row.label.kind)
            .all(|(_, reached)| reached.contains(&which(row)))
    };
    let of = |group: &Vec<&SweepRow>| {
        let shared: Vec<&SweepRow> = group.iter().copied().filter(shared).collect();
        summed(group, &shared)
    };
    all.iter().map(of).collect()
}

/// What is driven, whatever drives it: the world's name, and the seed.
type Which<'a> = (&'a str, u64);

fn which(row: &SweepRow) -> Which<'_> {
    (row.label.world.as_str(), row.label.seed)
}

fn reached<'a>(rows: &[&'a SweepRow]) -> BTreeSet<Which<'a>> {
    let reached = rows
        .iter()
        .filter(|row| row.outcome.result == CellResult::Reached);
    reached.map(|row| which(row)).collect()
}

fn same(one: &SweepRow, other: &SweepRow) -> bool {
    let (one, other) = (&one.label, &other.label);
    one.kind == other.kind
        && one.config == other.config
        && one.weights == other.weights
        && one.engine == other.engine
        && (one.vx_samples, one.vtheta_samples) == (other.vx_samples, other.vtheta_samples)
}

fn summed(rows: &[&SweepRow], shared: &[&SweepRow]) -> SweepGroup {
    let label = &rows[0].label;
    let count = |result| {
        let ended = rows.iter().filter(|row| row.outcome.result == result);
        ended.count()
    };
    let reached = || {
        rows.iter()
            .filter(|row| row.outcome.result == CellResult::Reached)
    };
    SweepGroup {
        kind: label.kind,
        config: label.config.clone(),
        weights: label.weights.clone(),
        engine: label.engine.clone(),
        vx_samples: label.vx_samples,
        vtheta_samples: label.vtheta_samples,
        samples: u64::from(label.vx_samples) * u64::from(label.vtheta_samples),
        runs: rows.len(),
        reached: count(CellResult::Reached),
        contacts: count(CellResult::Contact),
        timeouts: count(CellResult::Timeout),
        failed: count(CellResult::Failed) + count(CellResult::Error),
        mean_time_s: mean(reached().map(|row| row.outcome.time_s)),
        mean_shared_time_s: mean(shared.iter().map(|row| row.outcome.time_s)),
        shared: shared.len(),
        mean_score: mean(rows.iter().filter_map(|row| row.outcome.score)),
        mean_clearance_m: mean(rows.iter().filter_map(|row| row.outcome.min_clearance_m)),
    }
}
