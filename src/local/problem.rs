//! One decision to take, in metres, seconds and radians.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::ranges::in_range;
use super::{ClearanceField, ProblemError, Window};
use crate::documented::documented;
use crate::geometry::{Point, Pose};
use crate::map::MovingDisc;
use crate::robot::Footprint;

documented! {
    /// How much each term counts (paper, eq. 35: alpha, beta, gamma and lambda).
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct Weights {
        /// Of facing the target at the end (alpha), 0 to 1e6.
        pub heading: f64,
        /// Of keeping away from obstacles (beta), 0 to 1e6.
        pub clearance: f64,
        /// Of going fast (gamma), 0 to 1e6.
        pub velocity: f64,
        /// Of ending near the key node (lambda), 0 to 1e6. Its distance is subtracted: the paper prints a plus, yet says
        /// that smaller is better.
        pub path: f64,
    }
}

impl Default for Weights {
    /// The paper's (section 3.3.3).
    fn default() -> Self {
        Self {
            heading: 0.05,
            clearance: 0.25,
            velocity: 0.20,
            path: 0.15,
        }
    }
}

impl Weights {
    /// Checks every weight.
    ///
    /// # Errors
    /// Names the first that is not 0 to 1e6.
    pub fn validate(&self) -> Result<(), ProblemError> {
        for (quantity, value) in [
            ("weight heading", self.heading),
            ("weight clearance", self.clearance),
            ("weight velocity", self.velocity),
            ("weight path", self.path),
        ] {
            in_range(
                quantity,
                value,
                "",
                (0.0..=1e6).contains(&value),
                "0 to 1e6",
            )?;
        }
        Ok(())
    }
}

/// How the terms are brought to one scale before they are weighted, over the admissible samples only.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Normalization {
    /// Each term over its sum (eq. 33). A zero sum contributes nothing.
    #[default]
    Sum,
    /// Each term's place between its least (0) and greatest (1). A zero range contributes nothing.
    MinMax,
}

/// What a sample must be able to stop within (eq. 30).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Stopping {
    /// The smallest clearance along the trajectory: `v^2 <= 2 dist a`, as the paper has it.
    #[default]
    Clearance,
    /// The arc left before contact, as the original DWA (Fox, Burgard and Thrun 1997): a robot may pass fast between
    /// near walls. Steps after the first contact do not count towards the clearance then.
    Arc,
}

/// What lies beyond the field.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Outside {
    /// A trajectory that leaves the field is not admissible.
    #[default]
    Obstacle,
    /// Ground outside the field is free.
    Free,
}

/// Everything that one decision depends on.
///
/// Ranges, checked when the problem is quantized (a unit of length is 0.122 to 0.244 mm, see [`ClearanceField`]):
///
/// - map resolution 0.001 to 2 m; 1 to 4,194,304 samples; 1 to 1023 steps;
/// - speeds at most 15.99 m/s and, in one step, at most 16,384 units (at least 2 m) and 1.5 rad;
/// - the way over the horizon, the target and the key node at most 262,144 units off (at least 32 m);
/// - 1 to 8 discs within 32,767 units of the robot's origin along each axis (at least 4 m);
/// - clearance cap at least 1 mm, and with a disc's and an obstacle's radius at most 46,330 units (at least 5.6 m);
/// - at most 1024 moving obstacles; those near enough to matter at most 2^22 units off over the horizon (at least 512 m);
/// - the robot at most 2^29 units from the field's corner along each axis (at least 65 km);
/// - weights 0 to 1,000,000.
#[derive(Clone, Debug)]
pub struct Problem {
    /// Static obstacles.
    pub field: Arc<ClearanceField>,
    /// Where the robot is, in the map frame of the field.
    pub pose: Pose,
    /// The velocities to try.
    pub window: Window,
    /// Braking along the path, m/s^2, above zero.
    pub braking_x: f64,
    /// Braking of the turn, rad/s^2, above zero.
    pub braking_theta: f64,
    /// Length of a step, seconds.
    pub step_s: f64,
    /// Number of steps; poses are checked at steps 1 to this.
    pub steps: u32,
    /// The robot's shape.
    pub footprint: Footprint,
    /// Clearance beyond which more is not better, metres.
    pub max_clearance_m: f64,
    /// What lies beyond the field.
    pub outside: Outside,
    /// Moving obstacles as of now; each is met at the time of the step.
    pub obstacles: Vec<MovingDisc>,
    /// Where the robot should face at the end: the local target.
    pub target: Point,
    /// The key node of the global path that it should end near.
    pub key_node: Point,
    /// How much each term counts.
    pub weights: Weights,
    /// How the terms are brought to one scale.
    pub normalization: Normalization,
    /// What a sample must be able to stop within.
    pub stopping: Stopping,
}
