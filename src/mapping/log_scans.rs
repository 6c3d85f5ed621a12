//! The scans of a log without motion distortion.

use crate::geometry::Pose;
use crate::lidar_log::LidarLog;
use crate::localization::{DeskewedScan, PoseHistory};

/// A scan of a log, with the robot's pose at its end.
#[derive(Clone, Debug)]
pub struct LogScan {
    /// Index of the record in the log.
    pub record: usize,
    /// Pose by odometry.
    pub odometry: Pose,
    /// Corrected pose of the log.
    pub corrected: Option<Pose>,
    /// The beams in the robot's frame at that time.
    pub scan: DeskewedScan,
}

/// The scans of a log in its order, each corrected by odometry for the robot's motion during the scan.
#[must_use]
pub fn log_scans(log: &LidarLog) -> Vec<LogScan> {
    let mut history = PoseHistory::new();
    let mut scans = Vec::new();
    for (index, record) in log.records.iter().enumerate() {
        history.record(record.time_s, &record.odometry);
        if let Some(logged) = &record.scan {
            let mut scan = DeskewedScan::default();
            scan.deskew(&logged.beams, &history);
            let (odometry, corrected) = (record.odometry, record.corrected);
            scans.push(LogScan { record: index, odometry, corrected, scan });
        }
    }
    scans
}
