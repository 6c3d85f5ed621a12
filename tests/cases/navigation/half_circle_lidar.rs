//! Drives among people with a lidar that sees nothing behind the robot.

use core::f64::consts::PI;

use inbye::local::CpuEngine;
use inbye::runtime::{Config, Observer, PoseSource};
use inbye::sim::{Scene, Simulation, crossing, dead_end};

/// Drives through a scene among its people with this seed; the pose comes from the scans.
fn drive(scene: &Scene, seed: u64) {
    let mut config = Config::default();
    config.pose_source = PoseSource::Scans;
    let lidar = config.simulation.lidar.field_of_view_rad(PI).mount_x_m(0.35);
    config.simulation.lidar = lidar;
    let mission = scene.mission(600.0);
    let spawner = config.simulation.pedestrians.spawner(scene.obstacles, seed);
    let moving_obstacles = spawner.spawn_on_route(&mission, &config).expect("places for people");
    let simulation = Simulation { moving_obstacles, seed, ..Simulation::new(mission) };
    let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut |_| {} };
    let engine = Box::new(CpuEngine::single_threaded());
    let result = simulation.run(&config, engine, &mut observer).expect("a mission that can start");
    assert!(result.reached, "{seed}: {:?} after {} s", result.why(), result.time_s);
}

/// People stand on both ways to the goal, and go again. A plan around those that the robot sees led back as soon as it had turned.
#[test]
fn robot_among_people_does_not_turn_to_and_fro_between_two_paths() {
    drive(&crossing(), 1);
    drive(&crossing(), 6);
}

/// A person close to the lidar hides most of the map while the robot turns in place.
#[test]
fn robot_does_not_lose_its_pose_behind_people() {
    drive(&dead_end(), 5);
    drive(&dead_end(), 7);
}
