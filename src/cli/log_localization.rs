//! `inbye bench localization --log`: the localizer over the log of a real robot.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail, ensure};
use clap::Args;
use inbye::bench::{LogLocalization, LogRelations, RelationErrors, localize_log};
use inbye::geometry::Pose;
use inbye::lidar_log::LidarLog;
use inbye::map::OccupancyGrid;
use inbye::mapping::{LogScan, check_coordinates, check_ranges, log_scans, render};
use inbye::trajectory::{ErrorStatistics, RelationError, read_relations};

use super::arguments::real;
use super::localization::{LocalizationArguments, settings};
use super::log_file::LogFileArguments;
use super::map_log::warn_of_jump;
use super::{machine, map_file, output};

/// The flags of drives, which a log does not have.
const OF_DRIVES: [&str; 9] =
    ["goal", "case", "seeds", "seed", "tour", "slip", "out", "record", "threads"];

/// The flags of a log.
#[derive(Debug, Args)]
pub struct LogArguments {
    /// Log of a real robot instead of simulated drives.
    #[arg(long, value_name = "FILE", conflicts_with_all = OF_DRIVES)]
    pub log: Option<PathBuf>,
    #[command(flatten)]
    pub file: LogFileArguments,
    #[command(flatten)]
    pub truth: TruthArguments,
}

impl LogArguments {
    /// Rejects the flags of a log where none is named: they would do nothing.
    pub fn check_absence(&self) -> anyhow::Result<()> {
        let [scans, odometry] = self.file.topics().map(|(flag, topic)| (flag, topic.is_some()));
        for (flag, is_set) in [("--relations", self.truth.relations.is_some()), scans, odometry] {
            ensure!(!is_set, "{flag} belongs to --log: name the log");
        }
        Ok(())
    }
}

/// The ground truth of a log.
#[derive(Debug, Args)]
pub struct TruthArguments {
    /// Ground truth of the log: lines of t1 t2 x y z roll pitch yaw.
    #[arg(long, value_name = "FILE")]
    pub relations: Option<PathBuf>,
    /// Time of the relations minus time of the log, seconds.
    #[arg(long, value_name = "S", default_value_t = 0.0, allow_hyphen_values = true, requires = "relations", value_parser = real(f64::MIN..=f64::MAX, "seconds"))]
    pub time_offset: f64,
}

impl TruthArguments {
    /// The ground truth of a log, if it is named.
    pub fn read(&self, log: &LidarLog) -> anyhow::Result<Option<LogRelations>> {
        let Some(file) = &self.relations else {
            return Ok(None);
        };
        let relations = read_relations(file).context("--relations")?;
        Ok(Some(LogRelations::new(log, relations, self.time_offset)))
    }

    /// Warns if the ground truth was compared with nothing.
    pub fn warn_if_unused(&self, log: &LidarLog, truth: &LogRelations, is_used: bool) {
        let why = if is_used {
            return;
        } else if truth.is_empty() {
            "the file holds no relation"
        } else if !log.has_times {
            "the stamps of the log do not advance"
        } else {
            "no relation has both of its times on the log: check --time-offset"
        };
        let file = self.relations.as_deref().unwrap_or(Path::new(""));
        output::warn(format!("--relations {}: nothing is compared: {why}", file.display()));
    }
}

/// Localizes over a log. Returns false if the localizer was lost after the last scan, or after more than half of the scans.
pub fn run(arguments: &LocalizationArguments, file: &Path) -> anyhow::Result<bool> {
    let log = arguments.log.file.read(file).context("--log")?;
    let truth = arguments.log.truth.read(&log)?;
    ensure!(log.scans() > 0, "--log {}: it has no scans", file.display());
    let scans = log_scans(&log);
    check_ranges(&scans).with_context(|| format!("--log {}", file.display()))?;
    warn_of_jump(file.display(), &log);
    let config = settings(arguments)?;
    let resolution_m = arguments.resolution.of(arguments.map.as_deref())?;
    let map = match &arguments.map {
        Some(map) => map_file::load(map, resolution_m)?,
        None => own_map(&scans, file)?,
    };
    let start = arguments.start.as_ref().map(super::arguments::Place::pose).or_else(|| log.start());
    let start = start.unwrap_or_default();
    check_start(arguments, &map, &start)?;
    let mut clock = machine::wall_clock();
    let obstacles = map.obstacles(config.unknown);
    let truth = truth.as_ref();
    let result = localize_log(&log, &obstacles, &start, config.localization, truth, &mut clock)?;
    if let Some(truth) = truth {
        arguments.log.truth.warn_if_unused(&log, truth, result.relations.is_some());
    }
    output::result(&result, lines(&result))?;
    Ok(!result.is_lost_at_end && 2 * result.lost_scans <= result.scans)
}

/// An error for a start outside the map: no scan matches there.
fn check_start(
    arguments: &LocalizationArguments,
    map: &OccupancyGrid,
    start: &Pose,
) -> anyhow::Result<()> {
    let Some(file) = &arguments.map else {
        return Ok(());
    };
    let (Pose { x, y, .. }, file) = (start, file.display());
    let is_on_map = map.frame().cell_of(&start.position()).is_some();
    ensure!(
        is_on_map || arguments.start.is_none(),
        "--start {x},{y}: lies outside the map {file}: choose a place on the map"
    );
    ensure!(
        is_on_map,
        "{file}: the log's first pose ({x:.2}, {y:.2}) lies outside the map: name where the log starts with --start"
    );
    Ok(())
}

/// The map that the corrected poses of a log show.
fn own_map(scans: &[LogScan], file: &Path) -> anyhow::Result<OccupancyGrid> {
    let known = scans.iter().filter_map(|scan| Some((scan.corrected?, &scan.scan)));
    if known.clone().next().is_none() {
        bail!(
            "--log {}: it has no corrected poses to make a map from: name a map with --map, and make it with `inbye map`",
            file.display()
        );
    }
    check_coordinates(known.clone().map(|(pose, _)| pose))
        .with_context(|| format!("--log {}", file.display()))?;
    Ok(render(known)?)
}

fn lines(result: &LogLocalization) -> Vec<String> {
    let metres = |it: &ErrorStatistics| {
        format!(
            "rmse {:.4} m, mean {:.4} m, median {:.4} m, max {:.3} m",
            it.rmse, it.mean, it.median, it.max
        )
    };
    let degrees = |it: &ErrorStatistics| {
        format!("rmse {:.3} deg, max {:.2} deg", it.rmse.to_degrees(), it.max.to_degrees())
    };
    let mut lines = vec![format!(
        "log          {} scans{}, lost after {} of them{}",
        result.scans,
        result.duration_s.map_or_else(String::new, |it| format!(" in {it:.1} s")),
        result.lost_scans,
        result.lost_s.map_or_else(String::new, |it| format!(", for {it:.1} s")),
    )];
    if let Some(error) = &result.absolute {
        lines.push(format!(
            "absolute     {}; {}, over {} of the scans",
            metres(&error.position_m),
            degrees(&error.yaw_rad),
            error.poses
        ));
    }
    if let Some(error) = &result.relative {
        lines.push(format!(
            "relative     {}; {}, over {} motions",
            metres(&error.translation_m),
            degrees(&error.rotation_rad),
            error.motions
        ));
    }
    let relations = [("relations", &result.relations), ("log's own", &result.corrected_relations)];
    for (name, errors) in relations {
        lines.extend(errors.iter().flat_map(|errors| relation_lines(name, errors)));
    }
    if let [Some(median), Some(tail)] = result.scan_us {
        lines.push(format!("time         {median:.0} us a scan (median), {tail:.0} us (p99)"));
    }
    lines
}

/// Errors against relations, as they are published: against all, and against the definite ones.
pub fn relation_lines(name: &str, errors: &RelationErrors) -> Vec<String> {
    let mut lines = vec![format!("{name:<12} {}", relation_text(&errors.all))];
    lines.extend(errors.definite.map(|it| format!("  definite   {}", relation_text(&it))));
    lines
}

fn relation_text(error: &RelationError) -> String {
    format!(
        "{:.4} +- {:.4} m, {:.3} +- {:.3} deg, median {:.4} m and {:.3} deg, over {} relations",
        error.translation_m.mean,
        error.translation_m.sd,
        error.rotation_deg.mean,
        error.rotation_deg.sd,
        error.translation_m.median,
        error.rotation_deg.median,
        error.relations
    )
}
