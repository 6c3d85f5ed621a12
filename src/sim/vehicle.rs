//! What a mission moves: the simulated base, or one whose reported motion counts as true.

use super::{OdometryReading, SimBase};
use crate::base::Base;
use crate::geometry::{Pose, Twist};

/// A base in the simulated world.
pub trait Vehicle {
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

    /// Takes a command, which is finite, and lets a control period pass, seconds: simulated, or in truth. False when it was
    /// stopped for good, and the mission is over.
    fn drive(&mut self, command: &Twist, period_s: f64) -> bool;
}

impl Vehicle for SimBase {
    fn pose(&self) -> Pose {
        *self.pose()
    }

    fn twist(&self) -> Twist {
        self.twist()
    }

    fn odometry(&self) -> OdometryReading {
        self.odometry()
    }

    fn drive(&mut self, command: &Twist, period_s: f64) -> bool {
        // It refuses only commands that are not finite.
        let sent = self.send(command);
        debug_assert!(sent.is_ok());
        self.step(period_s);
        true
    }
}
