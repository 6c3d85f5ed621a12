//! A straight corridor with the goal straight ahead: the robot drives a straight line.

use std::sync::Arc;

use inbye::geometry::{Point, Pose};
use inbye::local::CpuEngine;
use inbye::map::{GridFrame, OccupancyGrid};
use inbye::navigator::{Goal, Mode};
use inbye::runtime::{Config, Mission, MissionResult, Observer};
use inbye::sim::Simulation;

const LENGTH_M: f64 = 24.0;
const CELL_M: f64 = 0.05;

/// A drive along the middle of a corridor between walls of half a metre.
fn drive(width_m: f64, seed: u64, config: &Config) -> MissionResult {
    let cells = |metres: f64| (metres / CELL_M).round() as i32;
    let frame = GridFrame::new(cells(LENGTH_M), cells(width_m + 1.0), CELL_M, Pose::default())
        .expect("a valid size");
    let map = OccupancyGrid::from_fn(frame, |cell| {
        let center = frame.center_of(cell);
        let along = 0.5..LENGTH_M - 0.5;
        let is_open = along.contains(&center.x) && (0.5..width_m + 0.5).contains(&center.y);
        if is_open { 0 } else { 100 }
    });
    let middle_m = 0.5 + width_m / 2.0;
    let goal = Goal::at(Point::new(LENGTH_M - 2.5, middle_m));
    let mission = Mission::new(Arc::new(map), Pose::new(2.0, middle_m, 0.0), goal);
    let simulation = Simulation { seed, ..Simulation::new(mission) };
    let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut |_| {} };
    let engine = Box::new(CpuEngine::single_threaded());
    simulation.run(config, engine, &mut observer).expect("a drive")
}

/// Noise of the pose displaces the robot by up to 2 cm.
#[test]
fn drive_along_a_straight_corridor_has_no_bend_and_no_oscillation() {
    for width_m in [1.6, 2.0, 3.0, 4.0] {
        for seed in 0..3 {
            let mut result = drive(width_m, seed, &Config::default());
            let which = format!("{width_m} m wide, seed {seed}");
            assert!(result.reached, "{which}: {:?}", result.why());
            // Parking corrects the last centimetres.
            result.trace.rows.retain(|row| row.mode == Mode::Driving);
            let rows = &result.trace.rows;
            let aside_m = |middle_m: f64| {
                rows.iter().map(|row| (row.pose.y - middle_m).abs()).fold(0.0, f64::max)
            };
            let aside_m = aside_m(0.5 + width_m / 2.0);
            let yaw = rows.iter().map(|row| row.pose.yaw.abs()).fold(0.0, f64::max);
            assert!(aside_m < 0.04, "{which}: {aside_m} m aside");
            assert!(yaw < 0.03, "{which}: {yaw} rad off the axis");
            assert_eq!(result.trace.omega_sign_changes(), 0, "{which}");
            let driven_m = rows.last().map_or(0.0, |row| row.pose.x - 2.0);
            assert!(driven_m > LENGTH_M - 6.5, "{which}: {driven_m} m without parking");
        }
    }
}

/// What counts as progress takes a slow robot longer than the patience of the settings.
#[test]
fn slow_robot_drives_the_corridor_without_an_escape() {
    for max_vel_x in [0.15, 0.06] {
        let mut config = Config::default();
        config.robot.limits.max_vel_x = max_vel_x;
        let result = drive(3.0, 0, &config);
        assert!(result.reached, "{max_vel_x} m/s: {:?}", result.why());
        let escapes = result.trace.rows.iter().filter(|row| row.mode == Mode::Escaping).count();
        assert_eq!((escapes, result.trace.paths.len()), (0, 1), "{max_vel_x} m/s");
    }
}
