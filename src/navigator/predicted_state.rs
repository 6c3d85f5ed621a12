//! The moment that a decision is taken for.

use crate::geometry::{Pose, Twist};
use crate::map::MovingDisc;
use crate::robot::Limits;

/// Where the robot and the moving obstacles will be when a command given now begins to act.
///
/// Radio, bus and motor take their time, and until then the robot moves as it was told before. To decide from where it
/// is now would be to brake too late by that way.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PredictedState {
    /// Time of the observation, seconds.
    pub time_s: f64,
    /// The robot then.
    pub pose: Pose,
    /// Its speed then, as far as it can have followed its last command.
    pub twist: Twist,
    /// The moving obstacles then.
    pub moving: Vec<MovingDisc>,
}

impl PredictedState {
    /// From what is seen now: the robot's pose and speed, moving obstacles, and the command it was given last.
    pub fn new(
        (time_s, pose, twist): (f64, &Pose, &Twist),
        moving: &[MovingDisc],
        last_command: &Twist,
        limits: &Limits,
        delay_s: f64,
    ) -> Self {
        let (pose, twist) = limits.advance(pose, twist, last_command, delay_s);
        Self {
            time_s,
            pose,
            twist,
            moving: moving.iter().map(|disc| disc.after(delay_s)).collect(),
        }
    }
}
