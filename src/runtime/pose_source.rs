//! The robot's pose in the map: from its own positioning, or from scans that are matched to the map.

use super::{Config, LidarData, PoseSource};
use crate::geometry::Pose;
use crate::localization::{LocalizationError, Localizer, LostReason, PoseEstimate};
use crate::map::{ObstacleGrid, TimedScan};

pub(super) enum PoseEstimator {
    /// The pose that the robot reported last.
    Fixes(Pose),
    Scans {
        localizer: Box<Localizer>,
        /// End of the last revolution that was matched, seconds.
        matched_s: Option<f64>,
    },
}

impl PoseEstimator {
    pub fn new(
        config: &Config,
        known: &ObstacleGrid,
        start: Pose,
    ) -> Result<Self, LocalizationError> {
        Ok(match config.pose_source {
            PoseSource::Fixes => Self::Fixes(start),
            PoseSource::Scans => Self::Scans {
                localizer: Box::new(Localizer::new(known, config.localization, &start)?),
                matched_s: None,
            },
        })
    }

    /// Updates the estimate with one tick. Without positioning of its own, the robot's pose is that of its odometry.
    pub fn update(
        &mut self,
        time_s: f64,
        odometry: &Pose,
        reported: Option<Pose>,
        lidar: Option<&LidarData>,
    ) {
        match self {
            Self::Fixes(pose) => *pose = reported.unwrap_or(*odometry),
            Self::Scans { localizer, matched_s } => {
                localizer.predict(time_s, odometry);
                match lidar {
                    Some(LidarData::Scan(scan)) => {
                        localizer.update(&TimedScan::from_scan(scan, time_s, 0.0));
                    }
                    Some(LidarData::TimedScan(sweep)) => {
                        let end_s = sweep.end_s();
                        if end_s.is_some() && end_s != *matched_s {
                            localizer.update(sweep);
                            *matched_s = end_s;
                        }
                    }
                    None => {}
                }
            }
        }
    }

    pub fn pose(&self) -> Pose {
        match self {
            Self::Fixes(pose) => *pose,
            Self::Scans { localizer, .. } => *localizer.pose(),
        }
    }

    /// The localizer's own report.
    pub fn fix(&self) -> Option<&PoseEstimate> {
        match self {
            Self::Fixes(_) => None,
            Self::Scans { localizer, .. } => Some(localizer.estimate()),
        }
    }

    pub fn lost(&self) -> Option<LostReason> {
        self.fix()?.status.lost_reason()
    }
}
