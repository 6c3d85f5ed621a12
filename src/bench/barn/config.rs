//! The robot of the challenge, and how it is driven: every setting of the benchmark in one place.

use core::f64::consts::PI;

use crate::local::{LocalSettings, Stopping};
use crate::navigator::NavigatorSettings;
use crate::robot::{Disc, Footprint, Limits};
use crate::sim::{Config, DriveDynamics, Fixes, Lidar, RobotConfig};

/// Half the width of the footprint, metres (`footprint` in the challenge's `costmap_common_params.yaml`: 0.42 by 0.33 m).
const HALF_WIDTH_M: f64 = 0.165;
/// A third of its length is twice this, metres.
const SIXTH_OF_LENGTH_M: f64 = 0.07;
/// The wheels' coefficient of friction is 0.5 in `jackal.urdf.xacro`: no wheel of it gains more than 4.9 m/s^2, whatever
/// its controller allows (20 m/s^2 and 25 rad/s^2 in `jackal_control/config/control.yaml` of `jackal/jackal`).
const ACCELERATION: f64 = 4.0;
const ANGULAR_ACCELERATION: f64 = 8.0;
/// Highest turn rate of the challenge's baseline, rad/s (`base_local_planner_params.yaml`); its controller allows 4.
const MAX_TURN_RATE: f64 = 1.57;

/// A Jackal with its front laser at a highest speed, m/s: 2 is what its controller allows, 0.5 what the challenge's
/// baseline drives at. The speed must be finite and above zero, or the configuration does not validate.
#[must_use]
pub fn barn_config(max_speed: f64) -> Config {
    Config {
        robot: RobotConfig {
            footprint: footprint(),
            // `track` of `jackal.urdf.xacro`.
            track_width_m: 0.376,
            limits: Limits {
                // Backing out slowly: the laser does not see behind.
                min_vel_x: -0.3_f64.min(max_speed),
                max_vel_x: max_speed,
                max_vel_theta: MAX_TURN_RATE,
                acc_lim_x: ACCELERATION,
                decel_lim_x: -ACCELERATION,
                acc_lim_theta: ANGULAR_ACCELERATION,
                decel_lim_theta: -ANGULAR_ACCELERATION,
            },
        },
        lidar: Lidar {
            // A SICK LMS111, Jackal's own front laser (`sick_lms1xx.urdf.xacro`: 720 beams, 30 m) over the 270 degrees
            // that the instrument has. Its noise is that of its datasheet, ten times that of Gazebo's.
            beams: 720,
            field_of_view_rad: 1.5 * PI,
            range_max_m: 30.0,
            range_sigma_m: 0.01,
            ..Lidar::default()
        },
        // No map, so nothing to be fixed to.
        fixes: Fixes {
            rate_hz: 0.0,
            ..Fixes::default()
        },
        dynamics: DriveDynamics::default(),
        local: LocalSettings {
            // The challenge's baseline decides 20 times a second.
            control_period_s: 0.05,
            // It looks 2 s ahead.
            sim_time_s: 2.0,
            sim_step_s: 0.1,
            vx_samples: 20,
            vtheta_samples: 41,
            // Beyond a metre, more room is worth nothing among cylinders that stand closer.
            max_clearance_m: 1.0,
            stopping: Stopping::Arc,
            ..LocalSettings::default()
        },
        navigator: NavigatorSettings {
            // The run ends 1 m from the goal; a robot that believes to be there has reason to go on.
            xy_goal_tolerance: 0.25,
            // The paths of the benchmark keep 0.375 m to the cylinders, the circle about the robot needs 0.32 m.
            safety_margin_m: 0.01,
            comfort_margin_m: 0.15,
            // In ten metres of cylinders every one counts at once.
            replan_period_s: 0.3,
            lookahead_m: 0.8,
            key_node_spacing_m: 0.2,
            // Nothing is gained by giving up early, but a run that is stuck this long never got free.
            give_up_after_s: 60.0,
            ..NavigatorSettings::default()
        },
        ..Config::default()
    }
}

/// Three discs that cover the footprint: each a third of its length.
fn footprint() -> Footprint {
    let radius = libm::hypot(HALF_WIDTH_M, SIXTH_OF_LENGTH_M);
    let discs = [-2.0, 0.0, 2.0].map(|sixths| Disc {
        x: sixths * SIXTH_OF_LENGTH_M,
        y: 0.0,
        radius,
    });
    Footprint::new(discs.to_vec()).expect("three discs with a radius")
}
