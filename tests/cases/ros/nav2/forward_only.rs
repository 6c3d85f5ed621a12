//! A robot that cannot reverse, with Nav2's parameters of the `TurtleBot3`, in a world of the `TurtleBot3`'s kind.

use std::sync::Arc;

use core::f64::consts::{FRAC_PI_3, PI};

use inbye::geometry::{Point, Pose};
use inbye::local::CpuEngine;
use inbye::map::OccupancyGrid;
use inbye::navigator::Goal;
use inbye::ros::nav2::import;
use inbye::runtime::{Config, Mission, Observer};
use inbye::sim::Simulation;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// The parameters of Nav2's `TurtleBot3` that describe robot and controller.
const PARAMETERS: &str = r#"
controller_server:
  ros__parameters:
    controller_frequency: 20.0
    controller_plugins: ["FollowPath"]
    goal_checker_plugins: ["general_goal_checker"]
    general_goal_checker:
      plugin: "nav2_controller::SimpleGoalChecker"
      xy_goal_tolerance: 0.25
      yaw_goal_tolerance: 0.25
    FollowPath:
      plugin: "dwb_core::DWBLocalPlanner"
      min_vel_x: 0.0
      max_vel_x: 0.26
      max_vel_theta: 1.0
      acc_lim_x: 2.5
      acc_lim_theta: 3.2
      decel_lim_x: -2.5
      decel_lim_theta: -3.2
      vx_samples: 20
      vtheta_samples: 20
      sim_time: 1.7
local_costmap:
  local_costmap:
    ros__parameters:
      robot_radius: 0.22
"#;

const RESOLUTION_M: f64 = 0.05;
const HALF_M: f64 = 2.75;
/// Distance of the walls of the hexagon from its centre.
const WALL_M: f64 = 2.4;
const PILLAR_RADIUS_M: f64 = 0.15;
const PILLAR_SPACING_M: f64 = 1.1;
/// Least distance of goals from obstacles.
const GOAL_GAP_M: f64 = 0.4;

/// Distance to the nearest wall or pillar.
fn gap_m(x: f64, y: f64) -> f64 {
    let wall = |side: u32| {
        let normal = f64::from(side) * FRAC_PI_3;
        WALL_M - x * libm::cos(normal) - y * libm::sin(normal)
    };
    let pillar = |index: i32| {
        let center = |index: i32| f64::from(index - 1) * PILLAR_SPACING_M;
        libm::hypot(x - center(index % 3), y - center(index / 3)) - PILLAR_RADIUS_M
    };
    (0..6).map(wall).chain((0..9).map(pillar)).fold(f64::INFINITY, f64::min)
}

fn world() -> OccupancyGrid {
    let cells = (2.0 * HALF_M / RESOLUTION_M) as u32;
    let center = |index: u32| (f64::from(index) + 0.5) * RESOLUTION_M - HALF_M;
    let row = |row: u32| {
        let cell = |column| if gap_m(center(column), center(row)) > 0.0 { '.' } else { '#' };
        (0..cells).map(cell).collect::<String>()
    };
    let rows: Vec<String> = (0..cells).rev().map(row).collect();
    OccupancyGrid::from_rows(&rows, RESOLUTION_M, Pose::new(-HALF_M, -HALF_M, 0.0)).expect("a map")
}

#[test]
fn turtlebot3_that_cannot_reverse_reaches_ten_random_goals() {
    let config: Config =
        toml::from_str(&import(PARAMETERS, None).expect("an import").config).expect("settings");
    assert_eq!(config.robot.limits.min_vel_x, 0.0);
    let map = Arc::new(world());
    let mut rng = Pcg64Mcg::seed_from_u64(13);
    let mut start = Pose::new(-1.65, 0.55, 0.0);
    for number in 0..10 {
        let goal = loop {
            let [x, y] = [0; 2].map(|_| rng.random_range(-HALF_M..HALF_M));
            if gap_m(x, y) >= GOAL_GAP_M && libm::hypot(x - start.x, y - start.y) > 1.0 {
                break Goal { position: Point::new(x, y), yaw: Some(rng.random_range(-PI..PI)) };
            }
        };
        let mission =
            Mission { time_limit_s: 150.0, ..Mission::new(Arc::clone(&map), start, goal) };
        let simulation = Simulation { seed: number, ..Simulation::new(mission) };
        let (mut clock, mut on_tick) = (|| 0.0, |_: &inbye::runtime::TickEvent<'_>| ());
        let mut observer = Observer { clock: &mut clock, on_tick: &mut on_tick };
        let engine = Box::new(CpuEngine::single_threaded());
        let result = simulation.run(&config, engine, &mut observer).expect("a mission");
        let case = format!("goal {number} {goal:?} from {start:?}: {:?}", result.fault);
        assert!(result.reached && !result.collided, "{case}");
        let reverses = |row: &inbye::runtime::TraceRow| row.command.linear < 0.0;
        assert!(!result.trace.rows.iter().any(reverses), "{case}");
        start = result.trace.rows.last().expect("rows").pose;
    }
}
