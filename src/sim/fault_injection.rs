//! Faults that are injected into a simulated drive.

use super::{Lidar, WrongPlanner};
use crate::geometry::Pose;
use crate::runtime::OdometryReading;

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
    /// The revolutions of the lidar are wrong.
    Lidar {
        /// Begin, seconds.
        from_s: f64,
        /// End, seconds; infinite for the rest of the drive.
        to_s: f64,
        /// The change.
        change: LidarChange,
    },
    /// The stamps of lidar and odometry are wrong, as after a jump of the sensors' clock.
    ClockJump {
        /// Begin, seconds.
        from_s: f64,
        /// End, seconds; infinite for the rest of the drive.
        to_s: f64,
        /// Stamp minus true time, seconds.
        by_s: f64,
    },
    /// The belts turn and the robot stands.
    Bogged {
        /// Begin, seconds.
        from_s: f64,
        /// End, seconds; infinite for the rest of the drive.
        to_s: f64,
    },
    /// The positioning gets no fixes: its pose follows the odometry alone.
    NoFixes {
        /// Begin, seconds.
        from_s: f64,
        /// End, seconds; infinite for the rest of the drive.
        to_s: f64,
    },
    /// The positioning repeats its last pose.
    PoseFrozen {
        /// Begin, seconds.
        from_s: f64,
        /// End, seconds; infinite for the rest of the drive.
        to_s: f64,
    },
    /// The commands of a wrong planner reach the sender instead of the navigator's.
    WrongPlanner {
        /// Begin, seconds.
        from_s: f64,
        /// End, seconds; infinite for the rest of the drive.
        to_s: f64,
        /// The planner.
        planner: WrongPlanner,
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

impl FaultInjection {
    /// Begin of the fault, seconds.
    #[must_use]
    pub const fn from_s(&self) -> f64 {
        self.period_s().0
    }

    /// Begin and end, seconds. A kidnapping is an event: its end is its begin.
    const fn period_s(&self) -> (f64, f64) {
        match *self {
            Self::Kidnapped { at_s, .. } => (at_s, at_s),
            Self::LidarOccluded { from_s, to_s }
            | Self::LidarSectorOccluded { from_s, to_s, .. }
            | Self::LidarFrozen { from_s, to_s }
            | Self::LidarSilent { from_s, to_s }
            | Self::Lidar { from_s, to_s, .. }
            | Self::ClockJump { from_s, to_s, .. }
            | Self::Bogged { from_s, to_s }
            | Self::NoFixes { from_s, to_s }
            | Self::PoseFrozen { from_s, to_s }
            | Self::WrongPlanner { from_s, to_s, .. }
            | Self::Odometry { from_s, to_s, .. } => (from_s, to_s),
        }
    }
}

/// The faults that are present at a time, seconds.
pub(super) fn active_faults(
    faults: &[FaultInjection],
    time_s: f64,
) -> impl Iterator<Item = &FaultInjection> {
    faults.iter().filter(move |fault| {
        let (from_s, to_s) = fault.period_s();
        (from_s..to_s).contains(&time_s)
    })
}

/// A change of the lidar's revolutions by a fault.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum LidarChange {
    /// This share of the beams, drawn for each revolution, measures nothing.
    Dropout(f64),
    /// Every range has the wrong sign.
    Negative,
    /// A revolution has no beams.
    Empty,
    /// Only one of this many beams is sent, and the angle between two beams is as many times larger.
    EveryNth(usize),
    /// Every direction is multiplied by this: the driver has the wrong angle between two beams.
    AngleScale(f64),
    /// This share of the beams, drawn for each revolution, returns from dust at a random part of its range.
    Ghosts(f64),
    /// The revolutions arrive this late, seconds, and their stamps say so.
    Late(f64),
    /// The stamps lie this far in the future, seconds.
    Ahead(f64),
    /// No revolution arrives: the last one stays the newest.
    Stopped,
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
        for fault in active_faults(faults, time_s) {
            let change = match fault {
                FaultInjection::Odometry { change, .. } => change,
                FaultInjection::ClockJump { by_s, .. } => {
                    stamp_s += by_s;
                    continue;
                }
                _ => continue,
            };
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

/// Transforms a base's own pose into the map, after all kidnappings so far and while it is bogged.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Displacement {
    /// The pose of the base's own frame in the map.
    frame: Pose,
    until_s: f64,
    /// The pose in the map at which the robot is bogged.
    bogged: Option<Pose>,
}

impl Displacement {
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
        let is_bogged = |fault: &FaultInjection| matches!(fault, FaultInjection::Bogged { .. });
        let before = self.pose_in_map(own);
        self.bogged = active_faults(faults, time_s).any(is_bogged).then_some(before);
        if let Some(held) = self.bogged {
            self.frame = held.frame_origin(own);
        }
        before
    }

    /// Whether the robot is bogged at the last of these times.
    pub const fn is_bogged(&self) -> bool {
        self.bogged.is_some()
    }

    /// The pose in the map after the faults that were applied so far.
    pub fn pose_in_map(&self, own: &Pose) -> Pose {
        if let Some(held) = self.bogged {
            return held;
        }
        if self.frame == Pose::default() {
            return *own;
        }
        self.frame.transform_pose(own)
    }
}
