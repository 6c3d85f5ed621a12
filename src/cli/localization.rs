//! `inbye bench localization`.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::Arc;

use anyhow::bail;
use clap::Args;
use inbye::bench::text_table;
use inbye::experiment::{
    Grid, LocalizationCase, LocalizationSite, RunRow, Setup, World, localization_config,
};
use inbye::runtime::{Config, PoseSource};
use inbye::sim::roadway;
use serde_json::json;

use super::arguments::{Place, real, whole};
use super::log_localization::{self, LogArguments};
use super::map_file::Resolution;
use super::runs::{RunArguments, unreached};
use super::{config, map_file, output};

/// Largest position and yaw errors of a tour, metres and radians.
const WITHIN: (f64, f64) = (0.05, 0.02);

/// Columns of the text table.
const COLUMNS: &str = "case seed outcome travelled_m pose_error_max_m pose_error_max_rad \
    pose_error_rms_m odometry_error_max_m pose_sigma_max_m lost_after_s driven_on_m found_after_s lost_reason";

/// `inbye bench localization`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  inbye bench localization --case tour --seeds 1 --tour 30\n\n\
    The simulator drives in a closed loop. The pose comes only from wheel odometry with slip and from scans matched to the map; \
    errors are relative to the true pose, at each tick. Cases: tour (back and forth), people, coarse_map (the map's cells are \
    twice the world's), smooth (a straight roadway without any feature along it), kidnapped (2 m back), kidnapped_far (anywhere), \
    kidnapped_to_twin (into an identical roadway), occluded, briefly_occluded, other_map. The cases smooth, kidnapped_to_twin and \
    other_map drive in built-in roadways, with --map too.\n\
    Without --map: two rough roadways of the built-in scenes. Without --config: a lidar of 450 beams in 0.1 s up to 12 m with 2 cm \
    of noise.\n\
    With --out the same command resumes where it was interrupted.\n\
    With --log the localizer gets the odometry and scans of a real robot, on --map or on a map made from the log's own corrected \
    poses. The errors are relative to these poses, after a rigid alignment, and with --relations to ground truth. Formats: those of \
    `inbye map`.\n\
    Exit status 1: the localizer was lost at the end of the log, or after more than half of its scans; a tour (cases tour and people) touched something, did not end, or was off by more than 0.05 m or 0.02 rad, or \
    a drive of any case did not start.")]
pub struct LocalizationArguments {
    /// Map of the world, in any format that `drive` reads; needs --start and --goal. With --log: the map of the log.
    #[arg(long)]
    pub map: Option<PathBuf>,
    #[command(flatten)]
    pub resolution: Resolution,
    /// Start of the drives, or of the log.
    #[arg(long, value_name = "X,Y[,YAW]", allow_hyphen_values = true, requires = "map")]
    pub start: Option<Place>,
    /// Place at which the drives turn back.
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, requires = "map")]
    pub goal: Option<Place>,
    /// Changes of the settings, TOML; those that make a drive depend on the wall clock are refused: `navigator.deadline_s`, and
    /// `navigator.wait_for_plans` = false.
    #[arg(long)]
    pub config: Option<PathBuf>,
    /// A case; repeatable, each is driven once [default: all].
    #[arg(long, value_name = "NAME", value_parser = case)]
    pub case: Vec<LocalizationCase>,
    /// Drives of each case, each with a seed of its own.
    #[arg(long, default_value_t = 3, allow_negative_numbers = true, value_parser = whole::<u64>(1, 10_000))]
    pub seeds: u64,
    /// The first seed.
    #[arg(long, default_value_t = 0, allow_negative_numbers = true, value_parser = whole::<u64>(0, 1_000_000_000))]
    pub seed: u64,
    /// Smallest length of a tour, metres.
    #[arg(long, default_value_t = 300.0, allow_negative_numbers = true, value_parser = real(1.0..=10_000.0, "metres, 1 to 10000"))]
    pub tour: f64,
    /// Share of each track's speed that is lost to slip [default: that of --config, or 0.05].
    #[arg(long, allow_negative_numbers = true, value_parser = real(0.0..=0.9, "0 to 0.9"))]
    pub slip: Option<f64>,
    #[command(flatten)]
    pub log: LogArguments,
    #[command(flatten)]
    pub run: RunArguments,
}

fn case(text: &str) -> Result<LocalizationCase, String> {
    let mut all = LocalizationCase::ALL.into_iter();
    all.find(|case| case.name() == text).ok_or_else(|| {
        let words = LocalizationCase::ALL.map(LocalizationCase::name);
        format!("it is one of {}", words.join(", "))
    })
}

/// Drives all cases. Returns false when a tour was not within its bounds, or a drive did not start.
pub fn run(arguments: &LocalizationArguments) -> anyhow::Result<bool> {
    if let Some(log) = &arguments.log.log {
        return log_localization::run(arguments, log);
    }
    arguments.log.check_absence()?;
    let site = Arc::new(site(arguments)?);
    let all = LocalizationCase::ALL;
    let cases = if arguments.case.is_empty() { &all[..] } else { &arguments.case };
    let mut seen = BTreeSet::new();
    let cases = cases.iter().copied().filter(|&case| seen.insert(case));
    let worlds: Vec<World> = cases.map(|case| World::localization(case, &site)).collect();
    let seeds: Vec<u64> = (arguments.seed..arguments.seed + arguments.seeds).collect();
    let setups = [Setup::unnamed(settings(arguments)?)];
    let grid = Grid::of_worlds("localization", &worlds, &setups, &seeds)?;
    let (rows, recorded) = arguments.run.run(&grid, |_| {})?;
    let within = rows.iter().all(is_within);
    let lines = text_table(&rows, COLUMNS).into_iter().chain(unreached(&rows));
    output::result(&json!({ "rows": rows, "within": within }), lines)?;
    recorded?;
    Ok(within)
}

/// The settings of drives and logs.
pub fn settings(arguments: &LocalizationArguments) -> anyhow::Result<Config> {
    let mut config = config::changed(localization_config(), arguments.config.as_deref())?;
    config.pose_source = PoseSource::Scans;
    let slip = &mut config.simulation.dynamics.slip.mean;
    *slip = arguments.slip.unwrap_or(*slip);
    Ok(config)
}

fn site(arguments: &LocalizationArguments) -> anyhow::Result<LocalizationSite> {
    let tour_m = arguments.tour;
    let resolution_m = arguments.resolution.of(arguments.map.as_deref())?;
    Ok(match (&arguments.map, &arguments.start, &arguments.goal) {
        (Some(file), Some(start), Some(goal)) => {
            let (name, map) = map_file::load_named(file, resolution_m)?;
            LocalizationSite { name, map, start: start.pose(), goal: goal.position, tour_m }
        }
        (None, None, None) => LocalizationSite::of_scene(roadway(), tour_m),
        _ => bail!("--map needs --start and --goal: name where drives start and turn back"),
    })
}

/// Whether a drive started, and a tour was within its bounds; other cases have none.
fn is_within(row: &RunRow) -> bool {
    let is_at_most = |error: Option<f64>, bound| error.is_some_and(|error| error <= bound);
    let is_tour = matches!(row.case, Some(LocalizationCase::Tour | LocalizationCase::People));
    let is_bounded = row.reached()
        && is_at_most(row.pose_error_max_m, WITHIN.0)
        && is_at_most(row.pose_error_max_rad, WITHIN.1)
        && row.lost_ticks == Some(0);
    row.ticks > 0 && (!is_tour || is_bounded)
}
