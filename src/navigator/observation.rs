//! Observations, and what makes one faulty.
//!
//! A robot that does not know where it is, or what is around it, brakes. It continues when the observations are valid again,
//! and the mission fails with a reason when that takes too long.

use std::collections::{BTreeMap, VecDeque};

use serde::{Serialize, Serializer};

use super::NavigatorSettings;
use super::frozen_scan::FrozenScan;
use super::scan_health::ScanHealth;
use crate::geometry::{Pose, Twist, Vector};
use crate::localization::LostReason;
use crate::map::{RayCaster, Scan, ScanError};
use crate::navigator::RobotModel;
use crate::robot::{Limits, is_plausible};

/// Jump by which a localisation may correct its pose, metres, beyond what the robot can have driven since.
const CORRECTION_M: f64 = 0.5;
/// Slip and noise may exceed the distance driven at the robot's speed limit by this factor.
const SPEED_FACTOR: f64 = 2.0;
/// This many poses in a row that agree about another place are accepted: the robot was relocalised, or carried.
const MIN_AGREEING: u32 = 5;
/// A longer time between two ticks is a jump of the clock, seconds: earlier scans and motion no longer count. A robot with a
/// faulty pose stands after this time, and gets no farther.
pub(super) const CLOCK_JUMP_S: f64 = 1.0;
/// Scan and odometry may have a time stamp this much after their tick, seconds: two clocks are never quite equal.
const CLOCK_TOLERANCE_S: f64 = 0.05;
/// A pose is frozen if it stays the same to the bit for this long, seconds, while the robot is commanded to drive at this
/// speed at least, m/s, or to turn at this rate, rad/s.
const FROZEN_S: f64 = 0.5;
const MIN_SPEED: f64 = 0.1;
const MIN_TURN_RATE: f64 = 0.2;
/// Poses and speeds are compared over this time, seconds, once the speeds add up to this distance, metres.
const COMPARED_S: f64 = 1.0;
const COMPARED_M: f64 = 0.2;
/// The motion is reversed where the poses move backwards by this share of that distance.
const REVERSED_SHARE: f64 = 0.5;

/// What the robot measures and knows at a tick.
#[derive(Clone, Debug)]
pub struct Observation {
    /// Time of the tick, seconds; never less than at the tick before.
    pub time_s: f64,
    /// Pose of the robot in the map frame, by its localisation.
    pub pose: Pose,
    /// Time of the last measurement that corrected the pose in the map, seconds, by the clock of `time_s`: the last matched
    /// revolution, or the stamp of the transform from the map. It may lie in the future by less than `pose_timeout_s`: AMCL
    /// dates its transforms ahead. The navigator brakes where it is older than `pose_timeout_s`.
    pub pose_s: f64,
    /// Why the localisation does not know the pose; `None` where it does.
    pub lost: Option<LostReason>,
    /// Velocity of the robot, by its odometry.
    pub twist: Twist,
    /// Time of that measurement, seconds, by the clock of `time_s`. The navigator brakes where it is older than
    /// `odometry_timeout_s`.
    pub odometry_s: f64,
    /// The latest lidar scan. The navigator brakes where it is older than `scan_timeout_s` or has no measurement.
    pub scan: Scan,
    /// Time of the scan, seconds, by the clock of `time_s`; unchanged where there is no newer scan.
    pub scan_s: f64,
    /// Time of the latest scan whose measured ranges differ from those of the scan before, seconds, by the clock of `scan_s`:
    /// see [`ScanChange`](crate::map::ScanChange).
    pub scan_changed_s: f64,
    /// The command that the sender sent since the last tick, after its protective layer; `None` where that is unknown: the
    /// navigator then assumes its own.
    pub sent: Option<Twist>,
}

impl Observation {
    /// Whether times, pose and speeds are finite.
    fn is_finite(&self) -> bool {
        self.time_s.is_finite()
            && self.pose_s.is_finite()
            && self.odometry_s.is_finite()
            && self.scan_s.is_finite()
            && self.scan_changed_s.is_finite()
            && self.pose.is_finite()
            && self.twist.is_finite()
            && self.sent.as_ref().is_none_or(Twist::is_finite)
    }
}

/// What is wrong with an observation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, thiserror::Error)]
#[non_exhaustive]
pub enum ObservationFault {
    /// A time, a part of the pose or a speed is not a finite number.
    #[error("a time, the pose or a speed is not finite")]
    NotFinite,
    /// The scan has no place or no directions.
    #[error("{0}")]
    InvalidScan(ScanError),
    /// The odometry reports a speed above 100 m/s, or a turn rate above 100 rad/s.
    #[error("odometry reports a speed or turn rate that no base reaches")]
    TooFast,
    /// The clock jumped, or a measurement is from the future.
    #[error("the clock jumped, or a measurement is from the future")]
    ClockJump,
    /// There is no scan, none with a measurement, or only an old one.
    #[error("there is no fresh scan with a measurement")]
    NoScan,
    /// The odometry is old.
    #[error("there is no fresh odometry")]
    NoOdometry,
    /// The pose in the map was not corrected for too long.
    #[error("nothing has corrected the pose in the map for too long")]
    NoPose,
    /// The lidar sends the same ranges again and again while the robot moves.
    #[error("the lidar is frozen: it sends the same ranges while the robot moves")]
    FrozenScan,
    /// The lidar has no returns where the map shows surfaces.
    #[error("the lidar is blind: it has no returns where the map shows surfaces")]
    LidarBlind,
    /// As [`Self::LidarBlind`], but only in a part of the directions. The robot stands where that is ahead; otherwise it drives
    /// on, and keeps out of that part.
    #[error(
        "the lidar is blind in some directions, or the map is out of date there: it has no returns where the map shows surfaces"
    )]
    LidarPartlyBlind,
    /// The lidar measures surfaces within the robot's outline.
    #[error(
        "the lidar measures surfaces within the robot's outline: clean it, move what stands before it, or raise its smallest range"
    )]
    LidarFouled,
    /// The localisation does not know the pose.
    #[error("the robot is lost: {0}")]
    Lost(LostReason),
    /// The pose jumped farther than the robot can drive.
    #[error("the pose jumps farther than the robot can drive")]
    PoseJump,
    /// The pose does not change although the robot drives.
    #[error(
        "the pose does not change although the robot is commanded to drive: odometry is frozen, or the tracks are stuck"
    )]
    PoseFrozen,
    /// The pose moves against the speed of the odometry.
    #[error(
        "the pose moves against the speed that odometry reports: one of the two has the wrong sign"
    )]
    MotionReversed,
}

/// Serializes as a string, so that it may be the key of an object.
impl Serialize for ObservationFault {
    fn serialize<S: Serializer>(&self, out: S) -> Result<S::Ok, S::Error> {
        let name = match self {
            Self::NotFinite => "not_finite",
            Self::InvalidScan(_) => "invalid_scan",
            Self::TooFast => "too_fast",
            Self::ClockJump => "clock_jump",
            Self::NoScan => "no_scan",
            Self::NoOdometry => "no_odometry",
            Self::NoPose => "no_pose",
            Self::FrozenScan => "frozen_scan",
            Self::LidarBlind => "lidar_blind",
            Self::LidarPartlyBlind => "lidar_partly_blind",
            Self::LidarFouled => "lidar_fouled",
            Self::Lost(LostReason::LostAgain) => LostReason::LostAgain.name(),
            Self::Lost(reason) => return out.collect_str(&format_args!("lost_{}", reason.name())),
            Self::PoseJump => "pose_jump",
            Self::PoseFrozen => "pose_frozen",
            Self::MotionReversed => "motion_reversed",
        };
        out.serialize_str(name)
    }
}

/// An accepted observation.
#[derive(Clone, Copy, Debug)]
struct Accepted {
    time_s: f64,
    pose: Pose,
    twist: Twist,
}

/// Validates observations, one after the other.
#[derive(Debug, Default)]
pub(super) struct ObservationValidator {
    last: Option<Accepted>,
    /// The last observation before the robot was lost.
    before_lost: Option<Accepted>,
    /// Whether an accepted pose was not where the robot can have driven to, since this was last taken: it was carried, or an earlier
    /// pose was wrong.
    pub is_relocated: bool,
    /// Times of the last tick, and of the last scan with a measurement.
    clock_s: Option<f64>,
    scan_s: Option<f64>,
    /// Another place, and how many poses in a row agreed about it.
    elsewhere: Option<(Pose, u32)>,
    frozen_since_s: Option<f64>,
    is_frozen: bool,
    is_reversed: bool,
    recent: VecDeque<Accepted>,
    frozen_scan: FrozenScan,
    /// In which directions the lidar sees.
    pub health: ScanHealth,
    /// What is wrong with the last observation.
    pub fault: Option<ObservationFault>,
    /// Number of faulty observations by kind.
    pub counts: BTreeMap<ObservationFault, u64>,
}

impl ObservationValidator {
    /// Validates an observation against the map and returns whether its scan is a new one that shows the surroundings.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn validate(
        &mut self,
        observation: &Observation,
        commanded: &Twist,
        robot: &RobotModel,
        settings: &NavigatorSettings,
        known: &RayCaster,
    ) -> Result<bool, ObservationFault> {
        let checked = self.check(observation, commanded, &robot.limits, settings);
        let validated = checked.and_then(|is_new| {
            if !settings.features.scan_health {
                return Ok(is_new);
            }
            if is_new {
                let scan = &observation.scan;
                self.health.look_for_own_body(scan, &robot.footprint);
                self.health.update(&observation.pose, scan, known);
            }
            self.health.fault().map_or(Ok(is_new && !self.health.is_suspect()), Err)
        });
        self.fault = validated.err();
        match validated {
            Ok(_) => {
                if self.health.blind_sectors() > 0 {
                    *self.counts.entry(ObservationFault::LidarPartlyBlind).or_default() += 1;
                }
            }
            Err(fault) => {
                *self.counts.entry(fault).or_default() += 1;
            }
        }
        validated
    }

    fn check(
        &mut self,
        seen: &Observation,
        commanded: &Twist,
        limits: &Limits,
        settings: &NavigatorSettings,
    ) -> Result<bool, ObservationFault> {
        if !seen.is_finite() {
            return Err(ObservationFault::NotFinite);
        }
        seen.scan.validate().map_err(ObservationFault::InvalidScan)?;
        if !is_plausible(&seen.twist) {
            return Err(ObservationFault::TooFast);
        }
        let now_s = seen.time_s;
        let before_s = self.clock_s.replace(now_s).unwrap_or(now_s);
        let elapsed_s = now_s - before_s;
        let is_ahead = seen.scan_s.max(seen.odometry_s) > now_s + CLOCK_TOLERANCE_S
            || seen.pose_s > now_s + settings.pose_timeout_s;
        if !(0.0..=CLOCK_JUMP_S).contains(&elapsed_s) || is_ahead {
            self.recent.clear();
            (self.frozen_since_s, self.elsewhere) = (None, None);
            // A scan timed by another clock has no age in this one.
            self.scan_s = self.scan_s.filter(|scan_s| *scan_s <= now_s);
            self.last = self.last.map(|last| Accepted { time_s: now_s, ..last });
            return Err(ObservationFault::ClockJump);
        }
        let measures = seen.scan.ranges.iter().any(|range| !range.is_nan());
        let is_new = measures && self.scan_s.is_none_or(|scan_s| seen.scan_s > scan_s);
        if is_new {
            self.scan_s = Some(seen.scan_s);
        }
        if self.scan_s.is_none_or(|scan_s| now_s - scan_s > settings.scan_timeout_s) {
            return Err(ObservationFault::NoScan);
        }
        if self.frozen_scan.update(seen, is_new) {
            return Err(ObservationFault::FrozenScan);
        }
        if let Some(why) = seen.lost {
            // The robot need not have driven to where it is found later.
            self.before_lost = self.last.take().or(self.before_lost);
            self.elsewhere = None;
            self.recent.clear();
            return Err(ObservationFault::Lost(why));
        }
        if now_s - seen.odometry_s > settings.odometry_timeout_s {
            return Err(ObservationFault::NoOdometry);
        }
        if now_s - seen.pose_s > settings.pose_timeout_s {
            return Err(ObservationFault::NoPose);
        }
        self.check_place(seen, limits)?;
        self.check_frozen(seen, commanded)?;
        self.check_direction(seen)?;
        Ok(is_new)
    }

    /// Rejects a pose that the robot cannot have driven to, until several agree.
    fn check_place(&mut self, seen: &Observation, limits: &Limits) -> Result<(), ObservationFault> {
        let fastest = limits.max_vel_x.max(-limits.min_vel_x);
        let is_near = |from: &Pose, elapsed_s: f64| {
            let distance_m = (seen.pose.position() - from.position()).norm();
            distance_m <= CORRECTION_M + SPEED_FACTOR * fastest * elapsed_s.min(CLOCK_JUMP_S)
        };
        let Some(last) = self.last else {
            let is_far = |before: Accepted| !is_near(&before.pose, seen.time_s - before.time_s);
            self.is_relocated |= self.before_lost.take().is_some_and(is_far);
            return Ok(());
        };
        if is_near(&last.pose, seen.time_s - last.time_s) {
            self.elsewhere = None;
            return Ok(());
        }
        let agreeing = match self.elsewhere {
            Some((place, agreeing)) if is_near(&place, 0.0) => agreeing + 1,
            _ => 1,
        };
        self.elsewhere = Some((seen.pose, agreeing));
        if agreeing < MIN_AGREEING {
            return Err(ObservationFault::PoseJump);
        }
        self.elsewhere = None;
        self.last = None;
        self.is_relocated = true;
        self.recent.clear();
        Ok(())
    }

    fn check_frozen(
        &mut self,
        seen: &Observation,
        commanded: &Twist,
    ) -> Result<(), ObservationFault> {
        let is_same = self.last.is_some_and(|last| last.pose == seen.pose);
        let drives =
            commanded.linear.abs() >= MIN_SPEED || commanded.angular.abs() >= MIN_TURN_RATE;
        self.is_frozen &= is_same;
        if is_same && drives {
            let since_s = *self.frozen_since_s.get_or_insert(seen.time_s);
            self.is_frozen |= seen.time_s - since_s > FROZEN_S;
        } else {
            self.frozen_since_s = None;
        }
        // A braking robot does not drive: the fault lasts until the pose changes.
        if self.is_frozen {
            return Err(ObservationFault::PoseFrozen);
        }
        Ok(())
    }

    /// Compares the motion by poses with the motion by speeds.
    fn check_direction(&mut self, seen: &Observation) -> Result<(), ObservationFault> {
        let now = Accepted { time_s: seen.time_s, pose: seen.pose, twist: seen.twist };
        self.last = Some(now);
        self.recent.push_back(now);
        while self.recent.front().is_some_and(|first| now.time_s - first.time_s > COMPARED_S) {
            self.recent.pop_front();
        }
        // Step by step, so that forward and backward motion do not cancel.
        let (mut along_speed_m, mut by_speed_m) = (0.0, 0.0);
        for (one, next) in self.recent.iter().zip(self.recent.iter().skip(1)) {
            let (sin, cos) = libm::sincos(one.pose.yaw);
            let speed = f64::midpoint(one.twist.linear, next.twist.linear);
            let step = next.pose.position() - one.pose.position();
            along_speed_m += step.dot(&Vector::new(cos, sin)) * speed.signum();
            by_speed_m += speed.abs() * (next.time_s - one.time_s);
        }
        // A wrong sign does not correct itself, and a standing robot shows none.
        self.is_reversed |= by_speed_m > COMPARED_M && along_speed_m < -REVERSED_SHARE * by_speed_m;
        if self.is_reversed {
            return Err(ObservationFault::MotionReversed);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
