//! What a mission moves: the simulated base, or one whose reported motion counts as true.

use crate::geometry::{Pose, Twist};
use crate::map::TimedScan;

/// What a base knows of its own motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OdometryReading {
    /// Where it believes to be: the pose in REP-105's `odom` frame, laid so that it is true at the start. It never jumps,
    /// and drifts from the truth without bound.
    pub pose: Pose,
    /// How fast it measures itself to move: the belts' mean speed, and the gyro's turn rate.
    pub twist: Twist,
}

/// A base in the simulated world.
pub trait Robot {
    /// Where it truly is.
    fn pose(&self) -> Pose;

    /// How fast it truly moves.
    fn twist(&self) -> Twist;

    /// What it knows of its motion by itself.
    fn odometry(&self) -> OdometryReading;

    /// What is wrong with it now, a sentence for people; none where nothing is, or where it cannot tell.
    fn trouble(&self) -> Option<String> {
        None
    }

    /// The newest whole revolution of a lidar of its own, by the clock of the mission, whose time is given in seconds; empty as long
    /// as there is none. None for a vehicle without one: then its lidar is simulated, and its pose is the truth.
    fn sweep(&mut self, _time_s: f64) -> Option<TimedScan> {
        None
    }

    /// Takes a command, which is finite, and lets a control period pass, seconds: simulated, or in truth. False when it was
    /// stopped for good, and the mission is over.
    fn drive(&mut self, command: &Twist, period_s: f64) -> bool;
}
