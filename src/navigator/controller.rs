//! The interface of controllers: one velocity for each input, in the words of `nav2_core::Controller`.

use crate::geometry::{Point, Pose, Twist};
use crate::global::Path;
use crate::local::ClearanceField;
use crate::map::{MovingDisc, Scan};
use crate::robot::{Footprint, Limits};

use super::Goal;

/// What a controller decides from at a tick. The navigator's own behaviours use nothing that does not follow from these inputs,
/// the map and the settings.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct ControllerInput<'a> {
    /// Time of the tick, seconds.
    pub time_s: f64,
    /// Control period, seconds.
    pub period_s: f64,
    /// Estimated pose in the map frame, at [`Self::odometry_s`].
    pub pose: Pose,
    /// Velocity that the base measured, at [`Self::odometry_s`].
    pub twist: Twist,
    /// Time of pose and velocity, seconds.
    pub odometry_s: f64,
    /// Pose when a command of this tick takes effect, predicted from the earlier commands.
    pub predicted_pose: Pose,
    /// Velocity at that time, likewise.
    pub predicted_twist: Twist,
    /// The command of the last tick.
    pub last_command: Twist,
    /// Limits of the base, as far as the drive has shown them.
    pub limits: &'a Limits,
    /// The body of the robot.
    pub footprint: &'a Footprint,
    /// The newest scan, in the robot's frame.
    pub scan: &'a Scan,
    /// Time of the scan, seconds.
    pub scan_s: f64,
    /// The static obstacles around the robot, of the map and of the scans so far. A cell with distance zero is occupied.
    pub local_grid: &'a ClearanceField,
    /// Tracked moving obstacles in the map frame, at the time of the scan.
    pub moving_obstacles: &'a [MovingDisc],
    /// The global path. It is replanned where obstacles block it; [`Controller::set_plan`] announces each new one.
    pub path: &'a Path,
    /// Length of the path behind the robot, metres.
    pub path_progress_m: f64,
    /// The key node of the path that the navigator's own behaviours would drive to.
    pub local_target: Point,
    /// The present goal.
    pub goal: &'a Goal,
}

impl<'a> ControllerInput<'a> {
    /// The input of a robot that stands at a pose at time zero, with a control period of 0.1 s and no moving obstacles, for the tests
    /// of a controller. Every field can be changed afterwards.
    #[must_use]
    pub const fn new(
        pose: Pose,
        (limits, footprint): (&'a Limits, &'a Footprint),
        scan: &'a Scan,
        local_grid: &'a ClearanceField,
        path: &'a Path,
        goal: &'a Goal,
    ) -> Self {
        Self {
            time_s: 0.0,
            period_s: 0.1,
            pose,
            twist: Twist::STOP,
            odometry_s: 0.0,
            predicted_pose: pose,
            predicted_twist: Twist::STOP,
            last_command: Twist::STOP,
            limits,
            footprint,
            scan,
            scan_s: 0.0,
            local_grid,
            moving_obstacles: &[],
            path,
            path_progress_m: 0.0,
            local_target: goal.position,
            goal,
        }
    }
}

/// Chooses the velocity of a robot that follows a global path.
///
/// The navigator does the rest, for every controller alike: it rejects faulty observations, marks and tracks obstacles, plans
/// and replans the path, checks progress, stops at the goal, and keeps commands within the limits of the base.
pub trait Controller: Send {
    /// Name for messages and tables.
    fn name(&self) -> &str;

    /// Takes a new path, which counts from the next input on.
    fn set_plan(&mut self, path: &Path);

    /// Returns the velocity to drive now. The navigator clamps it to the limits of the base.
    ///
    /// # Errors
    /// [`ControllerError`]. The robot then brakes.
    fn compute_velocity(&mut self, input: &ControllerInput<'_>) -> Result<Twist, ControllerError>;

    /// Forgets the drive so far: another goal begins.
    fn reset(&mut self);

    /// Ends the mission: no further input follows.
    ///
    /// # Errors
    /// [`ControllerError::Failed`] if it turns out that its velocities were not valid. The mission then has failed.
    fn finish(&mut self) -> Result<(), ControllerError> {
        Ok(())
    }
}

/// Why a controller returned no velocity.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ControllerError {
    /// It sees no valid velocity now. The robot brakes at this tick, and gives up if it makes no progress for long.
    #[error("{reason}")]
    NoValidControl {
        /// Its reason.
        reason: String,
    },
    /// Its answer is late. The robot brakes at this tick, or drives by an earlier command that decays if it has a deadline.
    #[error("the answer is late")]
    Late,
    /// It cannot go on: the mission fails.
    #[error("{reason}")]
    Failed {
        /// The cause.
        reason: String,
    },
    /// It did not answer for the longest time allowed: the mission fails.
    #[error("no answer for {after_s} s")]
    TimedOut {
        /// That time, seconds.
        after_s: f64,
    },
}

/// The answer of a controller at a tick.
pub type ControllerReply = Result<Twist, ControllerError>;
