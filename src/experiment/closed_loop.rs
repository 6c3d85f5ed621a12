//! What sampling density is worth in a closed loop: the same missions with more and more samples.

use core::cmp::Reverse;
use std::collections::BTreeMap;

use serde::Serialize;

use super::missions::{MissionRow, Setup, Tally, Which, mean, shared, times_s};
use super::soak::percentile;
use crate::bench::Columns;
use crate::bench::grid_counts;
use crate::runtime::Config;

/// What a sampling did with the missions.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ClosedLoopRow {
    /// Forward speeds tried at each decision.
    pub vx_samples: u32,
    /// Turn rates tried at each decision.
    pub vtheta_samples: u32,
    /// Samples: the product.
    pub samples: usize,
    /// Missions.
    pub missions: usize,
    /// Those that reached their goal.
    pub reached: usize,
    /// Contacts, whoever's motion brought them about.
    pub contacts: usize,
    /// Time taken beside that with the densest sampling, the mean over the missions that both reached.
    pub mean_time_ratio: Option<f64>,
    /// Missions that all samplings with any success reached.
    pub shared: usize,
    /// Time that these took, the median, seconds; none where there are none, or this sampling has no success.
    pub time_p50_s: Option<f64>,
    /// The same, the 90th percentile.
    pub time_p90_s: Option<f64>,
    /// Smallest gap, the mean over the missions reached, metres.
    pub mean_clearance_m: Option<f64>,
    /// Wall-clock time of a whole tick on one core, from the scan through the local field to the command, milliseconds: the
    /// median over missions of their medians.
    pub tick_p50_ms: Option<f64>,
    /// The median over missions of their 99th percentiles. Ticks that wait for a new global path are among these.
    pub tick_p99_ms: Option<f64>,
}

impl Columns for ClosedLoopRow {
    const COLUMNS: &[&str] = &[
        "vx_samples",
        "vtheta_samples",
        "samples",
        "missions",
        "reached",
        "contacts",
        "mean_time_ratio",
        "shared",
        "time_p50_s",
        "time_p90_s",
        "mean_clearance_m",
        "tick_p50_ms",
        "tick_p99_ms",
    ];
}

/// A configuration with each sampling: numbers of samples in so many shapes, forward speeds for each turn rate. Samplings
/// that come out the same are one.
#[must_use]
pub fn closed_loop_setups(config: &Config, samples: &[usize], shapes: &[f64]) -> Vec<Setup> {
    let mut setups: Vec<Setup> = Vec::new();
    for &samples in samples {
        for &shape in shapes {
            let (vx_samples, vtheta_samples) = grid_counts(samples, shape);
            let setup = setup(config, vx_samples, vtheta_samples);
            if setups.iter().all(|other| other.name != setup.name) {
                setups.push(setup);
            }
        }
    }
    setups
}

/// A configuration with so many forward speeds and turn rates, which give it its name.
fn setup(config: &Config, vx_samples: u32, vtheta_samples: u32) -> Setup {
    let mut config = config.clone();
    config.local.vx_samples = vx_samples;
    config.local.vtheta_samples = vtheta_samples;
    Setup {
        name: format!("{vx_samples}x{vtheta_samples}"),
        config,
    }
}

/// The same table from the rows of a record, whose setups tell the samplings by their names, as in `16x64`. From the
/// fewest samples to the most, and of as many first with the most forward speeds.
///
/// # Errors
/// The name of a setup that is no sampling.
pub fn closed_loop_of_record(rows: &[MissionRow]) -> Result<Vec<ClosedLoopRow>, String> {
    let mut names: Vec<&str> = rows.iter().map(|row| row.setup.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    let sampling = |name: &str| {
        let (vx_samples, vtheta_samples) = name.split_once('x')?;
        let made = setup(
            &Config::default(),
            vx_samples.parse().ok()?,
            vtheta_samples.parse().ok()?,
        );
        (made.name == name).then_some(made)
    };
    let setups = names
        .into_iter()
        .map(|name| sampling(name).ok_or_else(|| name.to_owned()));
    let mut setups: Vec<Setup> = setups.collect::<Result<_, _>>()?;
    setups.sort_by_key(|setup| (samples(setup), Reverse(setup.config.local.vx_samples)));
    Ok(closed_loop_rows(&setups, &rows.iter().collect::<Vec<_>>()))
}

/// The table of a closed loop, in the order of the setups. The densest of them is the yardstick; of equally dense ones the
/// first.
#[must_use]
pub fn closed_loop_rows(setups: &[Setup], rows: &[&MissionRow]) -> Vec<ClosedLoopRow> {
    let of_setup = |setup: &Setup| -> Vec<&MissionRow> {
        let own = rows.iter().copied();
        own.filter(|row| row.setup == setup.name).collect()
    };
    let all: Vec<_> = setups
        .iter()
        .map(|setup| {
            let rows = of_setup(setup);
            (setup, times_s(&rows), rows)
        })
        .collect();
    let shared = shared(all.iter().map(|(_, times_s, _)| times_s));
    let densest = all.iter().rev().max_by_key(|(setup, ..)| samples(setup));
    let row = |(setup, times_s, rows): &(&Setup, BTreeMap<Which, f64>, Vec<&MissionRow>)| {
        let tally = Tally::of(rows);
        let ratios = times_s.iter().filter_map(|(which, time_s)| {
            let (_, yardstick_s, _) = densest?;
            let least_s = yardstick_s.get(which).filter(|&&least_s| least_s > 0.0)?;
            Some(time_s / least_s)
        });
        let time_s = |share| {
            let times_s = shared
                .iter()
                .filter_map(|which| times_s.get(which).copied());
            percentile(times_s.collect(), share)
        };
        let middle = |figure: fn(&MissionRow) -> Option<f64>| {
            percentile(rows.iter().filter_map(|row| figure(row)).collect(), 0.5)
        };
        ClosedLoopRow {
            vx_samples: setup.config.local.vx_samples,
            vtheta_samples: setup.config.local.vtheta_samples,
            samples: samples(setup),
            missions: tally.missions,
            reached: tally.reached,
            contacts: tally.contacts_robot + tally.contacts_other,
            mean_time_ratio: mean(ratios),
            shared: shared.len(),
            time_p50_s: time_s(0.5),
            time_p90_s: time_s(0.9),
            mean_clearance_m: tally.mean_clearance_m,
            tick_p50_ms: middle(|row| row.tick_p50_ms),
            tick_p99_ms: middle(|row| row.tick_p99_ms),
        }
    };
    all.iter().map(row).collect()
}

const fn samples(setup: &Setup) -> usize {
    let local = &setup.config.local;
    local.vx_samples as usize * local.vtheta_samples as usize
}
