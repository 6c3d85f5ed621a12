//! Faults that are injected into a simulated drive.

use core::f64::consts::TAU;

use super::Lidar;
use crate::geometry::Pose;
use crate::runtime::{LidarData, OdometryReading};

/// A fault that happens to the simulated robot.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum FaultInjection {
    /// The robot is moved to another pose of the map; its odometry does not measure this.
    Kidnapped {
        /// Time of the fault, seconds.
        at_s: f64,
        /// The new pose.
        to: Pose,
    },
    /// The lidar measures no surface within its range, as behind a fogged window.
    LidarOccluded {
        /// Begin, seconds.
        from_s: f64,
        /// End, seconds; infinite for the rest of the drive.
        to_s: f64,
    },
    /// As [`Self::LidarOccluded`], but only in some directions of the robot's frame, as behind mud on a part of the window.
    LidarSectorOccluded {
        /// Begin, seconds.
        from_s: f64,
        /// End, seconds; infinite for the rest of the drive.
        to_s: f64,
        /// First direction, radians, counter-clockwise.
        from_rad: f64,
        /// Width, radians.
        width_rad: f64,
    },
    /// The lidar sends the first revolution of this time again and again, with new times.
    LidarFrozen {
        /// Begin, seconds.
        from_s: f64,
        /// End, seconds; infinite for the rest of the drive.
        to_s: f64,
    },
    /// The lidar returns no measurement.
    LidarSilent {
        /// Begin, seconds.
        from_s: f64,
        /// End, seconds; infinite for the rest of the drive.
        to_s: f64,
    },
    /// The odometry is wrong.
    Odometry {
        /// Begin, seconds.
        from_s: f64,
        /// End, seconds; infinite for the rest of the drive.
        to_s: f64,
        /// The change.
        change: OdometryChange,
    },
}

impl FaultInjection {
    /// The partial blindness of a lidar by its settings; none for a lidar that always sees.
    pub(super) fn blind_sector(lidar: &Lidar) -> Option<Self> {
        let half_rad = lidar.blind_width_rad / 2.0;
        (lidar.blind_time_s > 0.0).then_some(Self::LidarSectorOccluded {
            from_s: lidar.blind_start_s,
            to_s: lidar.blind_start_s + lidar.blind_time_s,
            from_rad: lidar.blind_direction_rad - half_rad,
            width_rad: lidar.blind_width_rad,
        })
    }
}

/// A change of the odometry by a fault.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum OdometryChange {
    /// The reading stays that of the begin, with new time stamps.
    Frozen,
    /// The sign of the speed is wrong.
    Reversed,
    /// The position is not a number.
    NotFinite,
    /// The position lies this far ahead in x, metres.
    Shifted(f64),
    /// The readings are this old, seconds, and their time stamps say so.
    Late(f64),
}

/// Changes readings of the odometry by faults.
#[derive(Clone, Debug, Default)]
pub(super) struct FaultyOdometry {
    /// The reading at the begin of a freeze.
    frozen: Option<OdometryReading>,
}

impl FaultyOdometry {
    /// Returns the report of a base that measured this at `odometry_s`, seconds, and the time stamp of the report.
    pub fn reported(
        &mut self,
        faults: &[FaultInjection],
        time_s: f64,
        measured: OdometryReading,
        odometry_s: f64,
    ) -> (OdometryReading, f64) {
        let (mut reading, mut stamp_s) = (measured, odometry_s);
        let mut is_frozen = false;
        for fault in faults {
            let FaultInjection::Odometry { from_s, to_s, change } = fault else {
                continue;
            };
            if !(*from_s..*to_s).contains(&time_s) {
                continue;
            }
            match change {
                OdometryChange::Frozen => {
                    is_frozen = true;
                    reading = *self.frozen.get_or_insert(reading);
                }
                OdometryChange::Reversed => reading.twist.linear = -reading.twist.linear,
                OdometryChange::NotFinite => reading.pose.x = f64::NAN,
                OdometryChange::Shifted(x_m) => reading.pose.x += x_m,
                OdometryChange::Late(by_s) => stamp_s -= by_s,
            }
        }
        if !is_frozen {
            self.frozen = None;
        }
        (reading, stamp_s)
    }
}

/// Transforms a base's own pose into the map, after all kidnappings so far.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Kidnapping {
    /// The pose of the base's own frame in the map.
    frame: Pose,
    until_s: f64,
}

impl Kidnapping {
    /// Applies the faults up to a time, seconds, which must not descend from call to call; returns the pose in the map.
    pub fn pose(&mut self, faults: &[FaultInjection], time_s: f64, own: &Pose) -> Pose {
        for fault in faults {
            if let FaultInjection::Kidnapped { at_s, to } = fault
                && (self.until_s..time_s).contains(at_s)
            {
                self.frame = to.frame_origin(own);
            }
        }
        self.until_s = self.until_s.max(time_s);
        self.pose_in_map(own)
    }

    /// The pose in the map after the faults that were applied so far.
    pub fn pose_in_map(&self, own: &Pose) -> Pose {
        if self.frame == Pose::default() {
            return *own;
        }
        self.frame.transform_pose(own)
    }
}

/// Returns a range that was measured at a time, seconds, in a direction of the robot's frame, radians, as the faults change
/// it.
pub(super) fn degraded_range(
    faults: &[FaultInjection],
    time_s: f64,
    direction: f64,
    range: f64,
) -> f64 {
    let mut range = range;
    for fault in faults {
        match fault {
            FaultInjection::LidarOccluded { from_s, to_s }
                if (*from_s..*to_s).contains(&time_s) =>
            {
                range = f64::INFINITY;
            }
            FaultInjection::LidarSectorOccluded { from_s, to_s, from_rad, width_rad }
                if (*from_s..*to_s).contains(&time_s)
                    && (direction - from_rad).rem_euclid(TAU) < *width_rad =>
            {
                range = f64::INFINITY;
            }
            FaultInjection::LidarSilent { from_s, to_s } if (*from_s..*to_s).contains(&time_s) => {
                range = f64::NAN;
            }
            _ => {}
        }
    }
    range
}

/// Repeats a revolution while the lidar is frozen.
#[derive(Clone, Debug, Default)]
pub(super) struct FrozenLidar(Option<LidarData>);

impl FrozenLidar {
    /// Returns the revolution that a lidar sends when it measured this at a time, seconds.
    pub fn sent(
        &mut self,
        faults: &[FaultInjection],
        time_s: f64,
        measured: LidarData,
    ) -> LidarData {
        let is_frozen = faults.iter().any(|fault| match fault {
            FaultInjection::LidarFrozen { from_s, to_s } => (*from_s..*to_s).contains(&time_s),
            _ => false,
        });
        if !is_frozen {
            self.0 = None;
            return measured;
        }
        match (self.0.get_or_insert_with(|| measured.clone()), measured) {
            (LidarData::TimedScan(kept), LidarData::TimedScan(mut sent)) => {
                for (sent, kept) in sent.beams.iter_mut().zip(&kept.beams) {
                    (sent.angle, sent.range) = (kept.angle, kept.range);
                }
                LidarData::TimedScan(sent)
            }
            (kept, _) => kept.clone(),
        }
    }
}
