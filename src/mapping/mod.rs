//! Maps from lidar logs: simultaneous localization and mapping, after the drive.
//!
//! Each scan is matched to the latest ones, by the scan matcher of [`localization`](crate::localization). A node of the pose
//! graph that sees an earlier part of the map closes a loop: branch and bound correlative scan matching over submaps (Hess et
//! al. 2016) finds its place, and the graph is optimised. At the end, all nodes that are near each other are matched again.
//!
//! Results are identical at every run and on every machine: all sums run in a fixed order on one thread, and trigonometry uses
//! `libm`.

mod log_scans;
mod loops;
mod mapper;
mod matching;
mod pose_graph;
mod render;
mod score_grid;
mod surfels;

pub use log_scans::{LogScan, log_scans};
pub use render::{MAP_RESOLUTION_M, render};

use crate::geometry::Pose;
use crate::lidar_log::LidarLog;
use crate::map::{MapError, OccupancyGrid};

/// A map from a log, with the poses that it rests on.
#[derive(Clone, Debug)]
pub struct MappedLog {
    /// Free, occupied and unknown cells. The first scan has the pose [`LidarLog::start`].
    pub map: OccupancyGrid,
    /// For each record of the log with a scan, its pose in the map frame.
    pub poses: Vec<Option<Pose>>,
    /// Number of nodes of the pose graph.
    pub nodes: usize,
    /// Number of closed loops.
    pub loops: usize,
    /// Number of scans that did not match the scans before them, and follow odometry.
    pub unmatched: usize,
}

/// Makes a map from the odometry and the scans of a log. Its corrected poses are not used, except for the first. `on_scan` is
/// called after each scan.
///
/// # Errors
/// Returns an error if the map is too large for a grid.
pub fn map_log(log: &LidarLog, on_scan: &mut dyn FnMut()) -> Result<MappedLog, MapError> {
    let scans = log_scans(log);
    let start = log.start().unwrap_or_default();
    let solved = mapper::solve(&scans, &start, on_scan);
    let placed = solved.poses.iter().copied().zip(scans.iter().map(|scan| &scan.scan));
    let map = render(placed)?;
    let mut poses = vec![None; log.records.len()];
    for (scan, pose) in scans.iter().zip(&solved.poses) {
        poses[scan.record] = Some(*pose);
    }
    let mapper::Solved { nodes, loops, unmatched, .. } = solved;
    Ok(MappedLog { map, poses, nodes, loops, unmatched })
}
