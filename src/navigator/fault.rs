//! Why a mission fails, under Nav2's error names where Nav2 has one, and what makes an observation faulty.

use std::fmt;

use serde::{Serialize, Serializer};
use thiserror::Error;

use crate::global::PlanError;
use crate::local::DecisionError;
use crate::localization::LostReason;
use crate::settings::SettingError;

/// Why a mission failed or could not start.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum Fault {
    /// There is no global path, or an end of it lies on an obstacle or off the map.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The local planner failed.
    #[error(transparent)]
    Choose(#[from] DecisionError),
    /// The robot found no admissible velocity for longer than `movement_time_allowance`, and no escape.
    #[error(
        "NO_VALID_CONTROL: {stuck_s:.0} s without an admissible velocity, {left_m:.1} m from the goal: obstacles are \
         within the margins on all sides"
    )]
    NoControl {
        /// Time without progress, seconds.
        stuck_s: f64,
        /// Remaining length of the path, metres.
        left_m: f64,
    },
    /// The robot made no progress along the path for longer than `movement_time_allowance`.
    #[error(
        "FAILED_TO_MAKE_PROGRESS: {stuck_s:.0} s without {radius_m} m of progress, {left_m:.1} m from the goal"
    )]
    NoProgress {
        /// Time without progress, seconds.
        stuck_s: f64,
        /// Length that counts as progress, metres.
        radius_m: f64,
        /// Remaining length of the path, metres.
        left_m: f64,
    },
    /// The operating system started no thread for the global planner.
    #[error("the planning thread did not start: {reason}")]
    NoThread {
        /// The error of the operating system.
        reason: String,
    },
    /// A setting is out of range.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// Observations were faulty for longer than the settings allow.
    #[error("INVALID_OBSERVATION: {fault}, {count} times in a row; the robot stops")]
    FaultyObservation {
        /// What was wrong with the last one.
        fault: ObservationFault,
        /// How many observations in a row were faulty.
        count: u32,
    },
}

/// What is wrong with an observation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum ObservationFault {
    /// A time, pose, speed or angle of the scan is not a finite number.
    NotFinite,
    /// The clock jumped, or the scan is from the future.
    ClockJump,
    /// There is no scan, none with a measurement, or only an old one.
    NoScan,
    /// The localisation does not know the pose.
    Lost(LostReason),
    /// The pose jumped farther than the robot can drive.
    PoseJump,
    /// The pose does not change although the robot drives.
    PoseFrozen,
    /// The pose moves against the speed of the odometry.
    MotionReversed,
}

impl ObservationFault {
    /// Returns the name used in JSON.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::NotFinite => "not_finite",
            Self::ClockJump => "clock_jump",
            Self::NoScan => "no_scan",
            Self::Lost(LostReason::NoReturns) => "lost_no_returns",
            Self::Lost(LostReason::BeamsThroughWalls) => "lost_beams_through_walls",
            Self::Lost(LostReason::PoorMatch) => "lost_poor_match",
            Self::Lost(LostReason::PoseJump) => "lost_pose_jump",
            Self::Lost(LostReason::HighUncertainty) => "lost_high_uncertainty",
            Self::PoseJump => "pose_jump",
            Self::PoseFrozen => "pose_frozen",
            Self::MotionReversed => "motion_reversed",
        }
    }
}

/// Serializes as a string, so that it may be the key of an object.
impl Serialize for ObservationFault {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.as_str())
    }
}

impl fmt::Display for ObservationFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Lost(why) => return write!(f, "the robot is lost: {why}"),
            Self::NotFinite => "time, pose, speed or the scan's angles are not finite",
            Self::ClockJump => "the clock jumped, or the scan is from the future",
            Self::NoScan => "there is no fresh scan with a measurement",
            Self::PoseJump => "the pose jumps farther than the robot can drive",
            Self::PoseFrozen => {
                "the pose does not change although the robot is commanded to drive: odometry is frozen, or the tracks are stuck"
            }
            Self::MotionReversed => {
                "the pose moves against the speed that odometry reports: one of the two has the wrong sign"
            }
        })
    }
}
