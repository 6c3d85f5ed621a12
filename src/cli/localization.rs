//! `inbye bench localization`.

use std::path::PathBuf;
use std::sync::Arc;

use anyhow::bail;
use clap::Args;
use inbye::bench::text_table;
use inbye::experiment::{LocalizationCase, LocalizationPlan, LocalizationRow};
use inbye::sim::{Lidar, Scene, roadway};
use serde_json::json;

use super::arguments::{Place, number, whole};
use super::output_file::Output;
use super::{config, map_file, output, output_file};

/// Largest position and yaw errors of a tour, metres and radians.
const WITHIN: (f64, f64) = (0.05, 0.02);

/// `inbye bench localization`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  inbye bench localization --case tour --seeds 1 --tour 30\n\n\
    The closed loop with the pose only from wheel odometry with slip and from scans matched to the map; errors are relative to \
    the simulator's truth, at each tick. Cases: tour (back and forth), people, coarse_map (the map's cells are \
    twice the world's), smooth (a straight roadway without any feature along it), kidnapped (2 m back), kidnapped_far (anywhere), \
    kidnapped_to_twin (into an identical roadway), occluded, briefly_occluded, other_map.\n\
    Without --map: two rough roadways of the built-in scenes. Without --config: a lidar of 450 beams in 0.1 s up to 12 m with 2 cm \
    of noise.\n\
    Exit status 1: a tour (cases tour and people) touched something, did not end, or was off by more than 0.05 m or 0.02 rad.")]
pub struct LocalizationArguments {
    /// Map that is the world, of any kind that `drive` reads; with --start and --goal.
    #[arg(long, requires_all = ["start", "goal"])]
    pub map: Option<PathBuf>,
    /// Side of a cell of a .map or text map, metres.
    #[arg(long, default_value_t = 1.0, allow_negative_numbers = true, value_parser = super::arguments::length)]
    pub resolution: f64,
    /// Where drives start.
    #[arg(long, value_name = "X,Y[,YAW]", allow_hyphen_values = true, requires = "map")]
    pub start: Option<Place>,
    /// Where they turn back.
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, requires = "map")]
    pub goal: Option<Place>,
    /// Settings, TOML.
    #[arg(long)]
    pub config: Option<PathBuf>,
    /// A case; repeatable [default: all].
    #[arg(long, value_name = "NAME", value_parser = case)]
    pub case: Vec<LocalizationCase>,
    /// Drives of each case, each with a seed of its own.
    #[arg(long, default_value_t = 3, allow_negative_numbers = true, value_parser = whole::<u64>(1, 10_000))]
    pub seeds: u64,
    /// The first seed.
    #[arg(long, default_value_t = 0, allow_negative_numbers = true, value_parser = whole::<u64>(0, 1_000_000_000))]
    pub seed: u64,
    /// Smallest length of a tour, metres.
    #[arg(long, default_value_t = 300.0, allow_negative_numbers = true, value_parser = tour_length)]
    pub tour: f64,
    /// Share of each track's speed that is lost to slip.
    #[arg(long, default_value_t = 0.05, allow_negative_numbers = true, value_parser = slip)]
    pub slip: f64,
    /// Write a row for each drive into this file, CSV or JSON by its ending.
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
}

fn case(text: &str) -> Result<LocalizationCase, String> {
    let mut all = LocalizationCase::ALL.into_iter();
    all.find(|case| case.name() == text).ok_or_else(|| {
        let words = LocalizationCase::ALL.map(LocalizationCase::name);
        format!("it is one of {}", words.join(", "))
    })
}

fn tour_length(text: &str) -> Result<f64, String> {
    number(text, |metres| (1.0..=10_000.0).contains(&metres), "metres, 1 to 10000")
}

fn slip(text: &str) -> Result<f64, String> {
    number(text, |share| (0.0..=0.9).contains(&share), "0 to 0.9")
}

/// Drives all cases. False when a tour was not within its bounds.
pub fn run(arguments: &LocalizationArguments, json: bool) -> anyhow::Result<bool> {
    let record = Output::create("--record", arguments.record.as_deref(), &["csv", "json"])?;
    let plan = plan(arguments)?;
    let cases = if arguments.case.is_empty() {
        LocalizationCase::ALL.to_vec()
    } else {
        arguments.case.clone()
    };
    let bar = output::progress(cases.len() as u64 * arguments.seeds, "localization");
    let mut rows = Vec::new();
    for case in cases {
        for seed in arguments.seed..arguments.seed + arguments.seeds {
            rows.push(plan.drive(case, seed)?);
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    if let Some(record) = record {
        output_file::write_rows(record, &rows)?;
    }
    if json {
        output::json(&json!({ "rows": rows, "within": rows.iter().all(is_within) }))?;
    } else {
        text_table(&rows, &COLUMNS).iter().for_each(output::line);
    }
    Ok(rows.iter().all(is_within))
}

fn plan(arguments: &LocalizationArguments) -> anyhow::Result<LocalizationPlan> {
    let mut config = config::load("--config", arguments.config.as_deref())?;
    if arguments.config.is_none() {
        config.simulation.lidar = Lidar::turning();
    }
    config.simulation.dynamics.slip.mean = arguments.slip;
    let (name, map, start, goal) = match (&arguments.map, &arguments.start, &arguments.goal) {
        (Some(file), Some(start), Some(goal)) => {
            let map = map_file::load(file, arguments.resolution)?;
            let name = file.file_stem().unwrap_or_default().to_string_lossy();
            let (start, goal) = (start.pose(), goal.position);
            (name.into_owned(), map, start, goal)
        }
        (None, None, None) => {
            let Scene { name, map, start, goal, .. } = roadway();
            (name.to_owned(), map, start, goal)
        }
        _ => bail!("--map needs --start and --goal: name where drives start and turn back"),
    };
    Ok(LocalizationPlan { name, map: Arc::new(map), start, goal, config, tour_m: arguments.tour })
}

/// Whether a tour was within its bounds; other cases have none.
fn is_within(row: &LocalizationRow) -> bool {
    let words = [LocalizationCase::Tour, LocalizationCase::People].map(LocalizationCase::name);
    !words.contains(&row.case.as_str())
        || row.reached
            && !row.collided
            && row.worst_m <= WITHIN.0
            && row.worst_rad <= WITHIN.1
            && row.lost_ticks == 0
}

/// Columns of the text table.
const COLUMNS: [&str; 14] = [
    "case",
    "seed",
    "reached",
    "collided",
    "travelled_m",
    "worst_m",
    "worst_rad",
    "rms_m",
    "odometry_worst_m",
    "sigma_m",
    "lost_after_s",
    "driven_on_m",
    "found_after_s",
    "lost_reason",
];
