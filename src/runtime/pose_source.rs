//! Where a simulated robot has its pose from: its odometry, held to the map by fixes or by scans.

use super::{Config, Mission, PoseSource};
use crate::geometry::Pose;
use crate::localization::{Localizer, LostReason, PoseEstimate};
use crate::map::{ObstacleGrid, Scan, TimedScan};
use crate::navigator::{PoseFilter, PoseMeasurement};
use crate::sim::{FixSource, SimError};

/// A deviation that is as good as none, metres and radians: a filter must not divide by zero.
const LEAST_SIGMA: f64 = 1e-6;

/// What the lidar showed at a tick.
pub(super) enum Seen {
    /// All beams at once, at the time of the tick.
    Scan(Scan),
    /// Beam after beam. It may be one that was seen before.
    Sweep(TimedScan),
}

#[expect(
    clippy::large_enum_variant,
    reason = "there is one of it in a simulation"
)]
pub(super) enum PoseEstimator {
    Fixes {
        source: FixSource,
        filter: PoseFilter,
        accuracy: PoseMeasurement,
    },
    Scans {
        localizer: Box<Localizer>,
        /// When the last revolution ended that was looked at.
        looked_s: Option<f64>,
    },
}

impl PoseEstimator {
    pub fn new(config: &Config, known: &ObstacleGrid, mission: &Mission) -> Result<Self, SimError> {
        let start = mission.start;
        if config.pose_source == PoseSource::Scans {
            let localizer = Localizer::new(known, config.localization, &start)?;
            return Ok(Self::Scans {
                localizer: Box::new(localizer),
                looked_s: None,
            });
        }
        let accuracy = PoseMeasurement {
            pose: start,
            sigma_m: config.fixes.sigma_m.max(LEAST_SIGMA),
            sigma_rad: config.fixes.sigma_rad.max(LEAST_SIGMA),
        };
        Ok(Self::Fixes {
            source: FixSource::new(config.fixes, mission.seed)?,
            filter: PoseFilter::new(&accuracy),
            accuracy,
        })
    }

    /// Takes in a tick: where odometry has the robot, where it truly is, and what its lidar shows.
    pub fn observe(&mut self, time_s: f64, odometry: &Pose, truth: &Pose, seen: &Seen) {
        match self {
            Self::Fixes {
                source,
                filter,
                accuracy,
            } => {
                filter.moved(odometry);
                if let Some(pose) = source.fix(time_s, truth) {
                    filter.fixed(&PoseMeasurement { pose, ..*accuracy });
                }
            }
            Self::Scans {
                localizer,
                looked_s,
            } => {
                localizer.predict(time_s, odometry);
                match seen {
                    Seen::Scan(scan) => {
                        localizer.update(&TimedScan::from_scan(scan, time_s, 0.0));
                    }
                    Seen::Sweep(sweep) => {
                        let end_s = sweep.end_s();
                        if end_s.is_some() && end_s != *looked_s {
                            localizer.update(sweep);
                            *looked_s = end_s;
                        }
                    }
                }
            }
        }
    }

    pub fn pose(&self) -> Pose {
        match self {
            Self::Fixes { filter, .. } => *filter.pose(),
            Self::Scans { localizer, .. } => *localizer.pose(),
        }
    }

    /// What a localiser says of it.
    pub fn fix(&self) -> Option<&PoseEstimate> {
        match self {
            Self::Fixes { .. } => None,
            Self::Scans { localizer, .. } => Some(localizer.estimate()),
        }
    }

    pub fn lost(&self) -> Option<LostReason> {
        self.fix()?.status.lost_reason()
    }
}
