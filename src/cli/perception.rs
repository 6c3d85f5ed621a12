//! `inbye bench perception`: the obstacle model over the log of a real robot.

use std::path::PathBuf;

use anyhow::{Context, bail};
use clap::Args;
use inbye::bench::{LogPerception, Perceived, perceive_log};

use super::log_file::LogFileArguments;
use super::{machine, output};

/// Arguments of `bench perception`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  inbye bench perception drive.log\n\nFirst the command makes a map of the log, as `inbye map` \
                  does. Then the obstacle model of the navigator gets all scans with the poses of that map: once with an empty map, \
                  and once with the map of the log."
)]
pub struct PerceptionArguments {
    /// Log of a real robot: CARMEN, GMapping, tinySLAM, or a recording of ROS 2.
    #[arg(value_name = "LOG")]
    log: PathBuf,
    #[command(flatten)]
    file: LogFileArguments,
}

/// Perceives the scans of a log.
pub fn run(arguments: &PerceptionArguments) -> anyhow::Result<bool> {
    let log = arguments.file.read(&arguments.log)?;
    if log.scans() == 0 {
        bail!("{}: it has no scans: name a log with a lidar", arguments.log.display());
    }
    let mut clock = machine::wall_clock();
    let result =
        perceive_log(&log, &mut clock).with_context(|| arguments.log.display().to_string())?;
    output::result(&result, lines(&result))?;
    Ok(true)
}

fn lines(result: &LogPerception) -> Vec<String> {
    let mut lines = vec![format!(
        "log          {} scans, {:.1} s of them with gaps below a second; {:.1} % of the beams have no measurement",
        result.scans,
        result.tracked_s,
        100.0 * result.unmeasured
    )];
    for (name, perceived) in [("empty map", &result.unknown), ("own map", &result.mapped)] {
        lines.extend(perceived_lines(name, perceived));
    }
    lines
}

fn perceived_lines(name: &str, perceived: &Perceived) -> [String; 3] {
    let or_none = |value: Option<f64>, unit: &str| {
        value.map_or_else(|| "none".to_owned(), |value| format!("{value:.2}{unit}"))
    };
    let [median_s, tail_s] = perceived.clear_s;
    let in_time = perceived.cleared_in_time.map(|share| 100.0 * share);
    [
        format!(
            "{name:<12} obstacles that moved: {} ({} on surfaces of the map), {} a minute, for {:.1} s in all",
            perceived.moving,
            perceived.on_surfaces,
            or_none(perceived.moving_per_min, ""),
            perceived.moving_s
        ),
        format!(
            "{:<12} {} marks cleared after {} (median) and {} (p90), {} within 0.5 s; {} late at the end",
            "",
            perceived.cleared,
            or_none(median_s, " s"),
            or_none(tail_s, " s"),
            or_none(in_time, " %"),
            perceived.late
        ),
        format!(
            "{:<12} {:.0} marks a scan; {} us a scan (median), {} us (p99)",
            "",
            perceived.marks,
            or_none(perceived.scan_us[0], ""),
            or_none(perceived.scan_us[1], "")
        ),
    ]
}
