//! How the robot of the challenge is driven among what moves: every setting of the benchmark in one place.

use crate::experiment::barn::barn_config;
use crate::local::{LocalSettings, Weights};
use crate::navigator::{NavigatorFeatures, NavigatorSettings};
use crate::robot::Limits;
use crate::runtime::{Config, RobotConfig};

/// The highest speed and turn rate that the Jackal's controller allows, m/s, forwards as backwards, and rad/s
/// (`jackal_control/config/control.yaml` of `jackal/jackal`).
const MAX_SPEED: f64 = 2.0;
const MAX_TURN_RATE: f64 = 4.0;

/// The Jackal of [`barn_config`] at 2 m/s, among cylinders as fast as itself.
#[must_use]
pub fn dynabarn_config() -> Config {
    let standing = barn_config(MAX_SPEED);
    Config {
        robot: RobotConfig {
            limits: Limits {
                // To get out of the way of what comes from ahead.
                min_vel_x: -MAX_SPEED,
                max_vel_theta: MAX_TURN_RATE,
                ..standing.robot.limits
            },
            ..standing.robot
        },
        local: LocalSettings {
            // Fewer arrived with 1.2 s, which sees too late, and with 2 s, which leaves too little to choose from.
            sim_time_s: 1.5,
            sim_step_s: 0.1,
            // In an open field there is room to be had, and it gives time: a cylinder shows that it moves only after half a
            // second and more, in which it comes a metre nearer.
            max_clearance_m: 2.0,
            weights: Weights {
                heading: 0.05,
                clearance: 0.2,
                velocity: 0.2,
                path: 0.4,
            },
            ..standing.local
        },
        navigator: NavigatorSettings {
            // Small, for it forbids: the room that is wanted is asked for by the clearance's weight.
            moving_margin_m: 0.15,
            passing_margin_m: 0.05,
            // Who creeps beside something that comes at 1.9 m/s is hit.
            passing_speed: MAX_SPEED,
            comfort_margin_m: 0.3,
            lookahead_m: 4.0,
            min_lookahead_m: 1.0,
            // As much as never: a robot that turns in place stands, and standing is being hit.
            rotate_in_place_from: 2.8,
            // Cylinders mind nobody: to stand before they come is to be hit.
            features: NavigatorFeatures {
                passive_safety: false,
                ..NavigatorFeatures::default()
            },
            ..standing.navigator
        },
        ..standing
    }
}
