//! The robot of the challenge, and how it is driven: every setting of the benchmark in one place.

use core::f64::consts::PI;

use crate::local::{LocalSettings, Stopping, Weights};
use crate::navigator::NavigatorSettings;
use crate::robot::{Disc, Footprint, Limits};
use crate::runtime::{Config, RobotConfig};
use crate::sim::{DriveDynamics, Fixes, Lidar};

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
            // that the instrument has, with noise ten times that in Gazebo.
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
            // As far as a metre and a bit at the speeds driven here, and the key node lies about there: with a key node
            // nearer than the horizon reaches, ending near it means driving slowly.
            sim_time_s: 1.0,
            sim_step_s: 0.05,
            vx_samples: 20,
            vtheta_samples: 41,
            // Beyond a metre, more room is worth nothing among cylinders that stand closer.
            max_clearance_m: 1.0,
            // The paper's rule, v^2 <= 2 dist a: it slows down beside things, not only before them. With `arc` three runs
            // of ten touched something: it brakes at the last moment, and the base brakes later than it is told.
            stopping: Stopping::Clearance,
            // Chosen by hand; by the study in the README the paper's own reach as many goals, 2 % sooner.
            weights: Weights {
                heading: 0.05,
                clearance: 0.1,
                velocity: 0.2,
                path: 0.4,
            },
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
            lookahead_m: 1.2,
            min_lookahead_m: 0.4,
            key_node_spacing_m: 0.25,
            // Nothing is gained by giving up early, but a run that is stuck this long never got free.
            movement_time_allowance: 60.0,
            ..NavigatorSettings::default()
        },
        ..Config::default()
    }
}

/// Centre and radius of the discs that cover the footprint, 0.42 by 0.33 m (`footprint` in the challenge's
/// `costmap_common_params.yaml`): two over its middle, whose outlines cross the sides at x = 0 and +-0.13 m, and one over
/// each corner. They reach 0.268 m from the middle, as the rectangle's corners do, and 12 mm beyond its sides; three
/// equal discs would reach 0.319 m, and the global planner, which plans for that circle, would find gaps closed that
/// are not.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Point, Pose};

    #[test]
    fn the_discs_cover_the_footprint_and_little_more() {
        let footprint = footprint();
        for step_x in 0..=84 {
            for step_y in 0..=66 {
                let (x, y) = (f64::from(step_x) * 0.005, f64::from(step_y) * 0.005);
                let point = Point::new(x - 0.21, y - 0.165);
                let gap_m = footprint.gap_to_disc_m(&Pose::default(), &point, 0.0);
                assert!(gap_m <= 1e-12, "{point} is {gap_m} m outside");
            }
        }
        assert!(footprint.circumscribed_radius_m() < libm::hypot(0.21, 0.165) + 0.001);
    }
}
