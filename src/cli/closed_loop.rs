//! The closed loop of `inbye bench density`.

use std::path::Path;

use inbye::bench::DensityPlan;
use inbye::experiment::missions::{MissionRow, Rules, built_in_sites};
use inbye::experiment::{ClosedLoopRow, closed_loop_rows, closed_loop_setups};
use inbye::runtime::Config;

use super::missions::{Driving, cells, one_core};

/// Fewest and most samples: with fewer no robot gets anywhere, with more a mission takes longer than it is worth.
const LEAST: usize = 64;
const MOST: usize = 16_384;
/// Longest path, metres.
const LONGEST_M: f64 = 30.0;
/// Seed of the first mission.
const SEED: u64 = 1;

const HEADER: &str = "  samples        v x omega  missions  reached  contacts  time by densest  mean gap m  \
    tick p50 ms  tick p99 ms";

/// Drives so many missions with each sampling of at most so many samples, one at a time, since ticks are timed. No missions,
/// no rows.
pub fn drive(
    missions: usize,
    most: usize,
    shapes: &[f64],
    record: Option<&Path>,
) -> anyhow::Result<Vec<ClosedLoopRow>> {
    if missions == 0 {
        return Ok(Vec::new());
    }
    let config = Config::default();
    let steps = config.local.steps();
    let plan = DensityPlan::powers_of_four(steps, LEAST.min(most), MOST.min(most), 1.0);
    let setups = closed_loop_setups(&config, &plan.samples, shapes);
    let sites = built_in_sites(&config);
    let rules = Rules {
        longest_m: LONGEST_M,
        ..Rules::default()
    };
    let driving = Driving {
        what: "closed loop",
        rules: &rules,
        threads: 1,
        record,
    };
    let rows = driving.run(&cells(&setups, &sites, missions, SEED), || Ok(one_core()))?;
    let rows: Vec<&MissionRow> = rows.iter().collect();
    Ok(closed_loop_rows(&setups, &rows))
}

/// The table; nothing where no mission was driven.
pub fn words(rows: &[ClosedLoopRow]) -> Vec<String> {
    if rows.is_empty() {
        return Vec::new();
    }
    let mut lines = vec![
        String::new(),
        "The same missions in closed loop; a tick is the whole one, scan, local field and decision, on one core."
            .to_owned(),
        HEADER.to_owned(),
    ];
    lines.extend(rows.iter().map(line));
    lines
}

fn line(row: &ClosedLoopRow) -> String {
    let grid = format!("{} x {}", row.vx_samples, row.vtheta_samples);
    let number = |value: Option<f64>, decimals: usize| {
        value.map_or_else(|| "-".to_owned(), |value| format!("{value:.decimals$}"))
    };
    format!(
        "{:9} {grid:>16} {:9} {:8} {:9} {:>16} {:>11} {:>12} {:>12}",
        row.samples,
        row.missions,
        row.reached,
        row.contacts,
        number(row.mean_time_ratio, 3),
        number(row.mean_clearance_m, 3),
        number(row.tick_p50_ms, 3),
        number(row.tick_p99_ms, 3),
    )
}
