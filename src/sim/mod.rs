//! A simulated robot and its world: ground, moving obstacles, a lidar, a tracked base, and injected faults.

mod drive;
mod episode;
mod error;
mod fault_injection;
mod faulty_lidar;
mod fixes;
mod gait;
mod lidar;
mod moving_obstacle;
mod moving_obstacles;
mod odometry;
mod past_obstacles;
mod pedestrian_spawner;
mod plant;
mod process_robot;
mod protected_sender;
mod recent_measurements;
mod route_sampler;
mod scenes;
mod simulated_lidar;
mod simulated_robot;
mod simulation;
mod sudden_pedestrians;
mod timed_path;
mod warped_map;
mod world;
mod wrong_planner;

pub use crate::runtime::simulation_settings::{
    DriveDynamics, Fixes, Lidar, OdometryNoise, PedestrianSettings, Slip, WrongPlanner,
};
pub use drive::SimBase;
pub use episode::Episode;
pub use error::SimError;
pub use fault_injection::{FaultInjection, LidarChange, OdometryChange};
pub use fixes::FixSource;
pub use lidar::{LidarReturn, RotatingLidar};
pub use moving_obstacle::{MovingObstacle, SpawnTrigger};
pub(crate) use moving_obstacles::YIELD_TIMEOUT_S;
pub use moving_obstacles::{MovingObstacles, YIELD_GAP_M};
pub use pedestrian_spawner::{PedestrianSpawner, first_path};
pub use plant::draw_plant;
#[cfg(feature = "experiment")]
pub(crate) use route_sampler::is_in_sight;
pub use scenes::{SCENE_NAMES, Scene, crossing, dead_end, mine, roadway, scene, scenes};
pub use simulated_robot::SimulatedRobot;
pub use simulation::Simulation;
pub use sudden_pedestrians::Surprise;
pub use timed_path::TimedPath;
pub use world::World;

use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

use crate::base::standard_normal;

/// The streams of random numbers of a run. They are independent: a change of one leaves the others unchanged. The values
/// are arbitrary.
#[derive(Clone, Copy)]
#[repr(u64)]
enum RngStream {
    Ground = 0x6a09_e667_f3bc_c908,
    Odometry = 0xbb67_ae85_84ca_a73b,
    Fixes = 0x3c6e_f372_fe94_f82b,
    Obstacles = 0xa54f_f53a_5f1d_36f1,
    WrongPlanner = 0x510e_527f_ade6_82d1,
    Plant = 0x9b05_688c_2b3e_6c1f,
    Map = 0x5be0_cd19_137e_2179,
    Lidar = 0x1f83_d9ab_fb41_bd6b,
}

/// Returns the generator of a stream.
fn generator(seed: u64, source: RngStream) -> Pcg64Mcg {
    Pcg64Mcg::seed_from_u64(seed ^ source as u64)
}

/// Draws from a normal distribution with mean zero. A deviation of zero gives zero and draws nothing.
fn normal(rng: &mut Pcg64Mcg, deviation: f64) -> f64 {
    if deviation > 0.0 { deviation * standard_normal(rng) } else { 0.0 }
}
