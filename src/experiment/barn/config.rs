//! The robot of the challenge and all settings of the benchmark.

use core::f64::consts::PI;

use crate::base::CollisionMonitorSettings;
use crate::local::{LocalSettings, Normalization, Stopping, Weights};
use crate::navigator::{NavigatorFeatures, NavigatorSettings};
use crate::robot::{Disc, Footprint, Limits};
use crate::runtime::{Config, RobotConfig, SimulationSettings};
use crate::sim::{Fixes, Lidar};

/// The wheels' coefficient of friction is 0.5 in `jackal.urdf.xacro`, so they accelerate by at most 4.9 m/s^2. The
/// controller allows more (20 m/s^2 and 25 rad/s^2 in `jackal_control/config/control.yaml` of `jackal/jackal`).
const ACCELERATION: f64 = 4.0;
const ANGULAR_ACCELERATION: f64 = 8.0;
/// Highest turn rate of the challenge's baseline, rad/s (`base_local_planner_params.yaml`); its controller allows 4.
const MAX_TURN_RATE: f64 = 1.57;

/// A Jackal with its front laser at this highest speed, m/s: its controller allows 2, the challenge's baseline drives at
/// 0.5. The configuration is valid only with a finite speed above zero.
#[must_use]
pub fn barn_config(max_speed: f64) -> Config {
    Config {
        robot: RobotConfig {
            footprint: footprint(),
            // `track` of `jackal.urdf.xacro`.
            track_width_m: 0.376,
            limits: Limits {
                // It backs out slowly: the laser does not see behind.
                min_vel_x: -0.3_f64.min(max_speed),
                max_vel_x: max_speed,
                max_vel_theta: MAX_TURN_RATE,
                acc_lim_x: ACCELERATION,
                decel_lim_x: -ACCELERATION,
                acc_lim_theta: ANGULAR_ACCELERATION,
                decel_lim_theta: -ANGULAR_ACCELERATION,
            },
        },
        simulation: SimulationSettings {
            lidar: Lidar {
                // A SICK LMS111, Jackal's own front laser (`sick_lms1xx.urdf.xacro`: 720 beams, 30 m) over the 270 degrees
                // that the instrument has, with noise ten times that in Gazebo.
                beams: 720,
                field_of_view_rad: 1.5 * PI,
                range_max_m: 30.0,
                range_sigma_m: 0.01,
                ..Lidar::default()
            },
            // There is no map to match scans to.
            fixes: Fixes { rate_hz: 0.0, ..Fixes::default() },
            ..SimulationSettings::default()
        },
        local: LocalSettings {
            // The challenge's baseline makes 20 decisions per second.
            control_period_s: 0.05,
            // It stops from 2 m/s within 0.5 s. A longer horizon costs speed for two reasons. The rule of `stopping` counts
            // cylinders that the robot reaches only at the end of the horizon. Arcs that end beyond the key node at 1.2 m score worse.
            sim_time_s: 0.6,
            sim_step_s: 0.05,
            vx_samples: 20,
            vtheta_samples: 41,
            // The paper's rule, v^2 <= 2 dist a: it slows down next to obstacles, not only in front of them. With `arc` three
            // runs of ten touched something: it brakes at the last moment, and the base brakes later than commanded.
            stopping: Stopping::Clearance,
            // Chosen by hand; the paper's weights reached as many goals in our study, 2 % sooner.
            weights: Weights { heading: 0.05, clearance: 0.1, velocity: 0.2, path: 0.4 },
            // These weights were chosen for it; with `minmax` the runs take 3 % longer.
            normalization: Normalization::Sum,
            ..LocalSettings::default()
        },
        navigator: NavigatorSettings {
            // The run ends 1 m from the true goal, so the robot continues when its estimated pose is there.
            xy_goal_tolerance: 0.25,
            // The paths of the benchmark are 0.375 m from the cylinders; the circle around the robot needs 0.32 m.
            safety_margin_m: 0.01,
            comfort_margin_m: 0.15,
            // Its cylinders look like legs.
            features: NavigatorFeatures {
                occlusion_speed: false,
                pairs_of_legs: false,
                ..NavigatorFeatures::default()
            },
            lookahead_m: 1.2,
            min_lookahead_m: 0.4,
            key_node_spacing_m: 0.25,
            // Giving up early gains nothing, but no run that was stuck for this long got free again.
            movement_time_allowance: 60.0,
            ..NavigatorSettings::default()
        },
        // At most the navigator's margin.
        collision_monitor: CollisionMonitorSettings {
            margin_m: 0.01,
            ..CollisionMonitorSettings::default()
        },
        ..Config::default()
    }
}

/// Centre and radius of the discs that cover the footprint, 0.42 by 0.33 m (`footprint` in the challenge's
/// `costmap_common_params.yaml`): two over its centre, whose outlines cross the sides at x = 0 and +-0.13 m, and one over
/// each corner. They reach 0.268 m from the centre, as the rectangle's corners do, and 12 mm beyond its sides. Three equal
/// discs would reach 0.319 m, and the global planner, which plans for that circle, would find open gaps closed.
const DISCS: [[f64; 3]; 6] = [
    [-0.065, 0.0, 0.1774],
    [0.065, 0.0, 0.1774],
    [-0.17, -0.125, 0.0566],
    [-0.17, 0.125, 0.0566],
    [0.17, -0.125, 0.0566],
    [0.17, 0.125, 0.0566],
];

fn footprint() -> Footprint {
    let discs = DISCS.map(|[x, y, radius]| Disc { x, y, radius });
    Footprint::new(discs.to_vec()).expect("six discs with a radius")
}
