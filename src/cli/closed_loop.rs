//! The closed loop of `inbye bench density`.

use std::path::Path;

use inbye::bench::{DensityPlan, text_table};
use inbye::experiment::missions::Rules;
use inbye::experiment::{Grid, Group, built_in_maps, groups, sampling_setups};
use inbye::runtime::Config;

use super::grid_run::run_grid;
use super::missions::sort;
use super::output_file;
use super::output_file::Output;

/// Smallest and largest number of samples: with fewer no robot arrives, with more a mission takes too long.
const MIN_SAMPLES: usize = 64;
const MAX_SAMPLES: usize = 16_384;
/// Longest path, metres.
const LONGEST_M: f64 = 30.0;
/// Seed of the first mission.
const SEED: u64 = 1;

/// Columns of the text table.
const COLUMNS: [&str; 10] = [
    "samples",
    "vx_samples",
    "vtheta_samples",
    "runs",
    "reached",
    "contacts",
    "mean_time_ratio",
    "mean_clearance_reached_m",
    "tick_p50_ms",
    "tick_p99_ms",
];

/// Drives this many missions with each sampling of at most `most` samples, one at a time, since ticks are timed. Without
/// missions there are no groups.
pub fn drive(
    missions: usize,
    most: usize,
    shapes: &[f64],
    record: Option<&Path>,
) -> anyhow::Result<Vec<Group>> {
    if missions == 0 {
        return Ok(Vec::new());
    }
    let record = Output::create("--record-missions", record, &["csv", "json"])?;
    let config = Config::default();
    let steps = config.local.steps();
    let (least, most) = (MIN_SAMPLES.min(most), MAX_SAMPLES.min(most));
    let samples = DensityPlan::powers_of_four(steps, least, most, 1.0).samples;
    let worlds = built_in_maps(Rules { longest_m: LONGEST_M, ..Rules::default() });
    let setups = sampling_setups(&config, &samples, shapes);
    let grid = Grid::of_missions("closed loop", &worlds, &setups, missions, SEED)?;
    let mut rows = run_grid(&grid, None, 1)?;
    sort(&mut rows);
    if let Some(record) = record {
        output_file::write_rows(record, &rows)?;
    }
    let mut groups = groups(&rows);
    let place = |group: &Group| {
        let is_own = |local: &inbye::local::LocalSettings| {
            (local.vx_samples, local.vtheta_samples) == (group.vx_samples, group.vtheta_samples)
        };
        setups.iter().position(|setup| is_own(&setup.config.local))
    };
    groups.sort_by_key(place);
    Ok(groups)
}

/// The table; no lines where no mission was driven.
pub fn text(groups: &[Group]) -> Vec<String> {
    if groups.is_empty() {
        return Vec::new();
    }
    let title =
        "The same missions in closed loop; a tick is scan, local field and decision, on one core.";
    let mut lines = vec![String::new(), title.to_owned()];
    lines.extend(text_table(groups, &COLUMNS));
    lines
}
