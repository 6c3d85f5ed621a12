//! The `DynaBARN` worlds (Nair et al. 2022): cylinders that move along scripts through an open field, and the attribution of
//! contacts between them and the robot.
//!
//! The cylinders ignore the robot, so it cannot avoid every contact. A plain success rate counts all contacts;
//! [`ContactAttribution`] finds those that the robot caused or could have avoided.
//!
//! Published results were measured in Gazebo; this simulator has no physics and no message delays. The cylinders move as
//! in Gazebo, on a Catmull-Rom spline with time linear between keyframes (`PoseAnimation` of `gazebosim/gazebo-classic`,
//! `Spline` of `gazebosim/gz-math`; its tension is zero by default).

mod contact_attribution;
mod world;

use crate::base::CollisionMonitorSettings;
use crate::experiment::barn::barn_config;
use crate::local::{LocalSettings, Weights};
use crate::navigator::{NavigatorFeatures, NavigatorSettings};
use crate::robot::Limits;
use crate::runtime::{Config, RobotConfig};

pub use contact_attribution::{ContactAttribution, State};
pub use world::{DynaBarnWorld, ScriptedCylinder, parse_world, read_world, read_worlds};

/// The highest speed and turn rate that the Jackal's controller allows, m/s forwards and backwards, and rad/s
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
                // It evades backwards from obstacles that come from ahead.
                min_vel_x: -MAX_SPEED,
                max_vel_theta: MAX_TURN_RATE,
                ..standing.robot.limits
            },
            ..standing.robot
        },
        local: LocalSettings {
            // Fewer runs arrived with 1.2 s, which reacts too late, and with 2 s, which leaves too few admissible samples.
            sim_time_s: 1.5,
            sim_step_s: 0.1,
            // An open field has room, and distance gives time: the tracker detects motion only after half a second and
            // more, in which a cylinder comes a metre closer.
            max_clearance_m: 2.0,
            weights: Weights { heading: 0.05, clearance: 0.2, velocity: 0.2, path: 0.4 },
            ..standing.local
        },
        navigator: NavigatorSettings {
            // Small, since it excludes samples; the clearance weight gives more distance.
            moving_margin_m: 0.15,
            passing_margin_m: 0.05,
            // Cylinders show their whole radius.
            pedestrian_radius_m: 0.0,
            // A slow robot next to a cylinder at 1.9 m/s is hit.
            passing_speed: MAX_SPEED,
            comfort_margin_m: 0.3,
            lookahead_m: 4.0,
            min_lookahead_m: 1.0,
            // The robot almost never turns in place: it would stand, and a standing robot is hit.
            rotate_in_place_from: 2.8,
            // The cylinders do not yield: a robot that stands in front of them is hit.
            features: NavigatorFeatures {
                passive_safety: false,
                occlusion_speed: false,
                ..NavigatorFeatures::default()
            },
            ..standing.navigator
        },
        // For the same reason: with the protective layer 0.72 of 60 runs arrive, without it 0.93.
        collision_monitor: CollisionMonitorSettings {
            enabled: false,
            ..standing.collision_monitor.clone()
        },
        ..standing
    }
}
