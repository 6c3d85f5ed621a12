//! `inbye map`: a map from the log of a real robot.

use core::fmt::Display;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use clap::Args;
use inbye::bench::{corrected_pairs, percentiles};
use inbye::lidar_log::{LidarLog, OdometryStep};
use inbye::mapping::{MappedLog, map_log};
use inbye::trajectory::{ErrorStatistics, absolute_error};
use serde_json::json;

use super::log_file::LogFileArguments;
use super::log_localization::{TruthArguments, relation_lines};
use super::map_output::MapOutput;
use super::{machine, output};

/// `inbye map`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  inbye map drive.log --out made.yaml\n\n\
    Formats: CARMEN (ODOM, FLASER, RLASER, ROBOTLASER1, RAWLASER1), GMapping's gfs, tinySLAM's dat, and ROS 2 recordings in MCAP (a file or the \
    folder of rosbag2) with LaserScan, Odometry and /tf_static. The map is a ROS map_server map, which every command can read. \
    Its image is next to it, and its cells are 0.05 m. The first scan has the log's first pose. The map does not depend on \
    corrected poses of the log. The result is compared with them and, with --relations, with ground truth.\n\
    The same log gives the same map, bit for bit.")]
pub struct MapLogArguments {
    /// The log.
    #[arg(value_name = "LOG")]
    pub log: PathBuf,
    /// The map to write; its image gets the same name with .pgm.
    #[arg(long, value_name = "FILE.yaml")]
    pub out: PathBuf,
    #[command(flatten)]
    pub file: LogFileArguments,
    #[command(flatten)]
    pub truth: TruthArguments,
}

/// Makes the map and writes it.
pub fn run(arguments: &MapLogArguments) -> anyhow::Result<bool> {
    let log = arguments.file.read(&arguments.log)?;
    let truth = arguments.truth.read(&log)?;
    if log.scans() == 0 {
        bail!("{}: it has no scans", arguments.log.display());
    }
    let output = MapOutput::create("--out", &arguments.out)?;
    let bar = output::progress(log.scans() as u64, "mapping", "scans");
    let mut clock = machine::wall_clock();
    let (mut times_us, mut before_s) = (Vec::new(), clock());
    let mapped = map_log(&log, &mut || {
        let now_s = clock();
        times_us.push((now_s - before_s) * 1e6);
        before_s = now_s;
        bar.inc(1);
    });
    let total_s = clock();
    bar.finish_and_clear();
    let mapped = mapped.with_context(|| arguments.log.display().to_string())?;
    warn_of_steps(&arguments.log, &log, &mapped);
    warn_of_unmatched(&arguments.log, &log, &mapped);
    let image = output.write(&mapped.map)?;
    let absolute = absolute_error(&corrected_pairs(&log, &mapped.poses));
    let relations = truth.as_ref().and_then(|truth| truth.errors(&log, &mapped.poses));
    if let Some(truth) = &truth {
        arguments.truth.warn_if_unused(&log, truth, relations.is_some());
    }
    let loops = ErrorStatistics::of(mapped.loop_errors_m.clone());
    let revisits = ErrorStatistics::of(mapped.revisit_errors_m.clone());
    let scan_us = percentiles(times_us, [0.5, 0.99]);
    let frame = mapped.map.frame();
    let object = json!({
        "map": arguments.out,
        "image": image,
        "width": frame.width,
        "height": frame.height,
        "resolution_m": frame.resolution_m,
        "format": log.format,
        "scans": log.scans(),
        "nodes": mapped.nodes,
        "unmatched": mapped.unmatched,
        "odometry_jumps": mapped.odometry_jumps.len(),
        "gaps": mapped.gaps.len(),
        "loops": mapped.loop_errors_m.len(),
        "loop_error_m": loops,
        "revisits": mapped.revisit_errors_m.len(),
        "revisit_error_m": revisits,
        "absolute": absolute,
        "relations": relations,
        "scan_us": scan_us,
        "total_s": total_s,
    });
    let mut lines = vec![
        format!(
            "map          {} ({} x {} cells)",
            arguments.out.display(),
            frame.width,
            frame.height
        ),
        scans_text(&log, &mapped, loops.as_ref()),
    ];
    lines.extend(revisits.map(|error| {
        format!(
            "revisits     {} pairs of nodes, off by {:.3} m (median), mean {:.3} m, max {:.3} m",
            mapped.revisit_errors_m.len(),
            error.median,
            error.mean,
            error.max
        )
    }));
    lines.extend(absolute.map(|error| {
        let (position, yaw) = (error.position_m, error.yaw_rad);
        format!(
            "absolute     rmse {:.4} m, mean {:.4} m, max {:.3} m; mean {:.3} deg from the log's corrected poses",
            position.rmse,
            position.mean,
            position.max,
            yaw.mean.to_degrees()
        )
    }));
    lines.extend(relations.iter().flat_map(|errors| relation_lines("relations", errors)));
    if let [Some(median), Some(tail)] = scan_us {
        lines.push(format!(
            "time         {median:.0} us a scan (median), {tail:.0} us (p99), {total_s:.1} s in all"
        ));
    }
    output::result(&object, lines)?;
    Ok(true)
}

/// Warns of steps of the odometry that no scan confirms.
fn warn_of_steps(file: &Path, log: &LidarLog, mapped: &MappedLog) {
    let file = file.display();
    let first = |records: &[usize]| {
        let step = records.first().and_then(|record| log.step_to_scan(*record))?;
        let places = if records.len() > 1 {
            format!(", the first of {} places", records.len())
        } else {
            String::new()
        };
        Some(format!("{}{places}", step_text(&step)))
    };
    if let Some(step) = first(&mapped.odometry_jumps) {
        output::warn(format!(
            "{file}: the odometry moves by {step}; the scan matches another place next to the scan before it, and the map follows the \
             scan: check the map there"
        ));
    }
    if let Some(step) = first(&mapped.gaps) {
        output::warn(format!(
            "{file}: the odometry moves by {step}; the scan matches no scan before it, so that the map before and after it may not fit \
             together: remove this step, or split the log"
        ));
    }
    if mapped.odometry_jumps.is_empty() && mapped.gaps.is_empty() {
        warn_of_jump(file, log);
    }
}

/// Warns of a step of the odometry that no robot drives.
pub fn warn_of_jump(file: impl Display, log: &LidarLog) {
    if let Some(step) = log.odometry_jump() {
        output::warn(format!(
            "{file}: the odometry jumps by {}: the scans before and after that may not fit together; remove this jump, or split \
             the log",
            step_text(&step)
        ));
    }
}

fn step_text(step: &OdometryStep) -> String {
    let OdometryStep { time_s, distance_m, turn_rad } = step;
    format!("{distance_m:.1} m and {turn_rad:.2} rad, at {time_s:.3} s")
}

/// Warns if most scans do not match others: such a map is worth no more than the odometry.
fn warn_of_unmatched(file: &Path, log: &LidarLog, mapped: &MappedLog) {
    let (unmatched, scans) = (mapped.unmatched, log.scans());
    if 2 * unmatched > scans {
        output::warn(format!(
            "{}: {unmatched} of {scans} scans do not match the scans before them, and follow the odometry: check the ranges, and the \
             place of the lidar on the robot",
            file.display()
        ));
    }
}

fn scans_text(log: &LidarLog, mapped: &MappedLog, loops: Option<&ErrorStatistics>) -> String {
    let loops = loops.map_or_else(
        || "no closed loop".to_owned(),
        |error| {
            format!(
                "{} closed loops that agree within {:.3} m (median)",
                mapped.loop_errors_m.len(),
                error.median
            )
        },
    );
    format!(
        "log          scans: {}, not matched: {}, nodes: {}; {loops}",
        log.scans(),
        mapped.unmatched,
        mapped.nodes
    )
}
