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
    /// Whether the odometry jumped since the scan before; then the scan is corrected for no motion before that.
    pub is_after_jump: bool,
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
    let mut is_after_jump = false;
    for (index, record) in log.records.iter().enumerate() {
        if log.jump_to(index).is_some() {
            // Beams before the jump have no pose after it.
            (history, is_after_jump) = (PoseHistory::new(), true);
        }
        history.record(record.time_s, &record.odometry);
        if let Some(logged) = &record.scan {
            let mut scan = DeskewedScan::default();
            scan.deskew(&logged.beams, &history);
            let (odometry, corrected) = (record.odometry, record.corrected);
            scans.push(LogScan { record: index, odometry, is_after_jump, corrected, scan });
            is_after_jump = false;
        }
    }
    scans
}
