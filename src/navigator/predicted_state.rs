//! Prediction over the time that a command takes to its effect.

use crate::geometry::{Pose, Twist};
use crate::map::MovingDisc;
use crate::robot::Limits;

/// The robot and the moving obstacles at the time when a command sent now takes effect.
///
/// Radio, bus and motor delay a command; until it takes effect the robot follows the last one. A decision for the present
/// pose would brake too late by the distance driven until then.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PredictedState {
    /// Time of the observation, seconds.
    pub time_s: f64,
    /// Predicted pose of the robot.
    pub pose: Pose,
    /// Predicted velocity, as far as the base can have followed the last command.
    pub twist: Twist,
    /// Predicted moving obstacles.
    pub moving: Vec<MovingDisc>,
}

impl PredictedState {
    /// Predicts from the observed time, pose and twist, the tracked obstacles and the last command.
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
