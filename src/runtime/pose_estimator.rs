//! The robot's pose in the map.

use super::{Config, Mission, PoseSource, SensorData};
use crate::geometry::{Pose, Twist};
use crate::localization::{
    LocalizationError, Localizer, LostReason, MapChanges, PoseEstimate, SignedDistanceField,
};
use crate::map::{ObstacleGrid, OccupancyGrid};

/// The robot's pose in the map: from its own positioning, or from scans that are matched to the map.
pub(super) enum PoseEstimator {
    /// The pose that the robot reported last, and the time of the measurement that corrected it, seconds, where that is known.
    Fixes(Pose, Option<f64>),
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
        mission: &Mission,
    ) -> Result<Self, LocalizationError> {
        let localizer = match config.pose_source {
            PoseSource::Fixes => return Ok(Self::Fixes(mission.start, None)),
            PoseSource::Scans if mission.is_start_unknown => {
                Localizer::without_pose(known, config.localization)
            }
            PoseSource::Scans => Localizer::new(known, config.localization, &mission.start),
        };
        Ok(Self::Scans { localizer: Box::new(localizer?), matched_s: None })
    }

    /// Updates the estimate with one tick. Without positioning of its own, the robot's pose is that of its odometry.
    pub fn update(&mut self, sensed: &SensorData) {
        let (time_s, odometry) = (sensed.odometry_s, &sensed.odometry.pose);
        match self {
            Self::Fixes(pose, corrected_s) => {
                *pose = sensed.pose.unwrap_or(*odometry);
                *corrected_s = sensed.pose_s;
            }
            Self::Scans { localizer, matched_s } => {
                localizer.predict(time_s, odometry);
                let Some(lidar) = &sensed.lidar else { return };
                let end_s = lidar.end_s(time_s);
                if end_s.is_some() && end_s != *matched_s {
                    localizer.update(&lidar.timed(time_s));
                    *matched_s = end_s;
                }
            }
        }
    }

    pub fn pose(&self) -> Pose {
        match self {
            Self::Fixes(pose, _) => *pose,
            Self::Scans { localizer, .. } => *localizer.pose(),
        }
    }

    /// Time of the last measurement that corrected the pose, seconds, given that of the odometry: a positioning of the
    /// robot's own without times is as old as its odometry. The pose at the start is of the mission's start.
    pub fn pose_s(&self, odometry_s: f64) -> f64 {
        match self {
            Self::Fixes(_, corrected_s) => corrected_s.unwrap_or(odometry_s),
            Self::Scans { matched_s, .. } => matched_s.unwrap_or(0.0),
        }
    }

    /// What the scans contradicted in the map for minutes.
    pub fn map_changes(&self, map: &OccupancyGrid) -> Option<MapChanges> {
        match self {
            Self::Fixes(..) => None,
            Self::Scans { localizer, .. } => Some(localizer.map_changes(map)),
        }
    }

    /// Matches the scans to a changed map.
    pub fn adopt_changes(&mut self, changed: Option<SignedDistanceField>) {
        if let (Self::Scans { localizer, .. }, Some(changed)) = (self, changed) {
            localizer.adopt_changes(changed);
        }
    }

    /// Learned scale of odometry's distances and turns.
    pub fn odometry_scale(&self) -> Option<(f64, f64)> {
        match self {
            Self::Fixes(..) => None,
            Self::Scans { localizer, .. } => Some(localizer.odometry_scale()),
        }
    }

    /// The measured velocity over the ground: belts that slip are faster than the robot.
    pub fn ground_twist(&self, measured: &Twist) -> Twist {
        let (distance, turn) = self.odometry_scale().unwrap_or((1.0, 1.0));
        Twist::new(measured.linear * distance, measured.angular * turn)
    }

    /// The localizer's own report.
    pub fn fix(&self) -> Option<&PoseEstimate> {
        match self {
            Self::Fixes(..) => None,
            Self::Scans { localizer, .. } => Some(localizer.estimate()),
        }
    }

    pub fn lost(&self) -> Option<LostReason> {
        self.fix()?.status.lost_reason()
    }
}
