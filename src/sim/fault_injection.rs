//! Faults that are injected into a simulated drive.

use core::f64::consts::TAU;

use super::error::at_least_zero;
use super::recent_measurements::RecentMeasurements;
use super::{Lidar, WrongPlanner};
use crate::geometry::Pose;
use crate::runtime::OdometryReading;
use crate::settings::{SettingError, require};

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

    /// Whether the fault is of the commands, and not of the simulated robot or its sensors.
    pub(super) const fn is_of_sender(&self) -> bool {
        matches!(self, Self::WrongPlanner { .. })
    }

    /// Checks the numbers of the fault.
    ///
    /// # Errors
    /// Names the first one out of range.
    pub fn validate(&self) -> Result<(), SettingError> {
        let (from_s, to_s) = self.period_s();
        finite(if matches!(self, Self::Kidnapped { .. }) { "at_s" } else { "from_s" }, from_s)?;
        require(to_s >= from_s, "to_s", to_s, "at least from_s")?;
        match *self {
            Self::Kidnapped { to, .. } => {
                finite("to.x", to.x)?;
                finite("to.y", to.y)?;
                finite("to.yaw", to.yaw)
            }
            Self::LidarSectorOccluded { from_rad, width_rad, .. } => {
                finite("from_rad", from_rad)?;
                let is_angle = (0.0..=TAU).contains(&width_rad);
                require(is_angle, "width_rad", width_rad, "at least zero and at most 2 pi")
            }
            Self::Lidar { change, .. } => change.validate(),
            Self::ClockJump { by_s, .. } => finite("by_s", by_s),
            Self::Odometry { change, .. } => change.validate(),
            Self::LidarOccluded { .. }
            | Self::LidarFrozen { .. }
            | Self::LidarSilent { .. }
            | Self::Bogged { .. }
            | Self::NoFixes { .. }
            | Self::PoseFrozen { .. }
            | Self::WrongPlanner { .. } => Ok(()),
        }
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

/// Rejects a number that is not finite.
const fn finite(name: &'static str, value: f64) -> Result<(), SettingError> {
    require(value.is_finite(), name, value, "finite")
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
    /// The revolutions arrive this late, seconds, and their stamps say so. The other changes apply to those that arrive.
    Late(f64),
    /// The stamps lie this far in the future, seconds.
    Ahead(f64),
    /// No revolution arrives: the last one stays the newest.
    Stopped,
}

impl LidarChange {
    fn validate(&self) -> Result<(), SettingError> {
        let share = |name, share: f64| {
            require((0.0..=1.0).contains(&share), name, share, "at least zero and at most one")
        };
        match *self {
            Self::Dropout(dropout) => share("Dropout", dropout),
            Self::Ghosts(ghosts) => share("Ghosts", ghosts),
            Self::EveryNth(count) => require(count > 0, "EveryNth", count as f64, "at least 1"),
            Self::AngleScale(ratio) => finite("AngleScale", ratio),
            Self::Late(late_s) => at_least_zero("Late", late_s),
            Self::Ahead(ahead_s) => finite("Ahead", ahead_s),
            Self::Negative | Self::Empty | Self::Stopped => Ok(()),
        }
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
    /// The readings arrive this late, seconds, and their time stamps say so. The other changes apply to those that arrive.
    Late(f64),
}

impl OdometryChange {
    fn validate(&self) -> Result<(), SettingError> {
        match *self {
            Self::Shifted(x_m) => finite("Shifted", x_m),
            Self::Late(late_s) => at_least_zero("Late", late_s),
            Self::Frozen | Self::Reversed | Self::NotFinite => Ok(()),
        }
    }
}

/// Changes readings of the odometry by faults.
#[derive(Clone, Debug, Default)]
pub(super) struct FaultyOdometry {
    /// The reading at the begin of a freeze.
    frozen: Option<OdometryReading>,
    /// Recent readings and their stamps, seconds; only for an odometry with late ones.
    recent: RecentMeasurements<(OdometryReading, f64)>,
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
        let late_s = |fault: &FaultInjection| match fault {
            FaultInjection::Odometry { change: OdometryChange::Late(late_s), .. } => Some(*late_s),
            _ => None,
        };
        let measured = (measured, odometry_s);
        let arriving = self.recent.arriving(faults, time_s, late_s, || measured);
        let (mut reading, mut stamp_s) = arriving.unwrap_or(measured);
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
                // It came first: the others change what arrives.
                OdometryChange::Late(_) => {}
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
                // A robot that is bogged and carried away is bogged at its new place.
                self.bogged = None;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Twist;

    const ALWAYS: (f64, f64) = (0.0, f64::INFINITY);

    fn lidar(change: LidarChange) -> FaultInjection {
        let (from_s, to_s) = ALWAYS;
        FaultInjection::Lidar { from_s, to_s, change }
    }

    fn odometry(change: OdometryChange) -> FaultInjection {
        let (from_s, to_s) = ALWAYS;
        FaultInjection::Odometry { from_s, to_s, change }
    }

    #[test]
    fn numbers_out_of_range_are_errors_with_their_name() {
        let to = Pose::new(0.0, 0.0, f64::NAN);
        let (from_s, to_s) = ALWAYS;
        for (fault, expected) in [
            (lidar(LidarChange::EveryNth(0)), "EveryNth is 0: it must be at least 1"),
            (lidar(LidarChange::Dropout(1.5)), "Dropout is 1.5"),
            (lidar(LidarChange::Ghosts(-0.1)), "Ghosts is -0.1"),
            (lidar(LidarChange::Late(f64::NAN)), "Late is NaN"),
            (odometry(OdometryChange::Late(-1.0)), "Late is -1"),
            (FaultInjection::Kidnapped { at_s: 1.0, to }, "to.yaw is NaN"),
            (FaultInjection::Kidnapped { at_s: f64::NAN, to: Pose::default() }, "at_s is NaN"),
            (FaultInjection::Bogged { from_s: 2.0, to_s: 1.0 }, "to_s is 1"),
            (FaultInjection::ClockJump { from_s, to_s, by_s: f64::INFINITY }, "by_s is inf"),
        ] {
            let error = fault.validate().expect_err("a number out of range").to_string();
            assert!(error.contains(expected), "{error}");
        }
        for fault in [lidar(LidarChange::EveryNth(2)), FaultInjection::LidarSilent { from_s, to_s }]
        {
            assert_eq!(fault.validate(), Ok(()));
        }
    }

    #[test]
    fn bogged_robot_that_is_carried_away_is_bogged_at_its_new_place() {
        let to = Pose::new(7.0, 8.0, 0.5);
        let faults = [
            FaultInjection::Bogged { from_s: 1.0, to_s: 3.0 },
            FaultInjection::Kidnapped { at_s: 2.0, to },
        ];
        let mut displacement = Displacement::default();
        let at = |x: f64| Pose::new(x, 0.0, 0.0);
        assert_eq!(displacement.pose(&faults, 0.5, &at(0.5)), at(0.5));
        assert_eq!(displacement.pose(&faults, 1.5, &at(1.0)), at(1.0));
        for (time_s, own_x) in [(2.1, 1.5), (2.5, 2.0)] {
            let pose = displacement.pose(&faults, time_s, &at(own_x));
            assert!((pose.position() - to.position()).norm() < 1e-9, "{pose:?}");
        }
        assert!(displacement.is_bogged());
    }

    fn moving(time_s: f64) -> OdometryReading {
        OdometryReading { pose: Pose::new(time_s, 0.0, 0.0), twist: Twist::new(time_s, 0.0) }
    }

    #[test]
    fn late_odometry_has_the_readings_of_its_stamps() {
        let mut faulty = FaultyOdometry::default();
        let faults = [odometry(OdometryChange::Late(1.0))];
        for tick in 0..40 {
            let time_s = 0.1 * f64::from(tick);
            let (reading, stamp_s) = faulty.reported(&faults, time_s, moving(time_s), time_s);
            assert_eq!((reading.pose.x, reading.twist.linear), (stamp_s, stamp_s));
            let age_s = time_s - stamp_s;
            assert!(time_s < 1.05 || (age_s - 1.0).abs() < 0.11, "{age_s} at {time_s}");
        }
    }

    #[test]
    fn each_late_odometry_has_its_delay_and_the_changes_listed_before_it() {
        let late = |from_s: f64, to_s: f64, by_s: f64| FaultInjection::Odometry {
            from_s,
            to_s,
            change: OdometryChange::Late(by_s),
        };
        let reversed = odometry(OdometryChange::Reversed);
        let faults = [reversed, late(0.0, 4.0, 0.5), late(4.0, 8.0, 2.0)];
        let mut faulty = FaultyOdometry::default();
        for second in 0..10 {
            for eighth in 0..8 {
                let time_s = f64::from(8 * second + eighth) / 8.0;
                let (reading, stamp_s) = faulty.reported(&faults, time_s, moving(time_s), time_s);
                assert_eq!((reading.pose.x, reading.twist.linear), (stamp_s, -stamp_s));
                let late_s = [0.5, 2.0, 0.0][usize::min(second as usize / 4, 2)];
                assert_eq!(stamp_s, (time_s - late_s).max(0.0), "at {time_s}");
            }
        }
    }
}
