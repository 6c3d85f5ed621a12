//! A simulated robot and its world: ground, moving obstacles, a lidar, a tracked base, and injected faults.

mod drive;
mod error;
mod fault_injection;
mod fixes;
mod lidar;
mod mine_map;
mod moving_obstacle;
mod moving_obstacles;
mod obstacle_file;
mod odometry;
mod patrol;
mod pedestrian_spawner;
mod random_waypoint;
mod ray;
mod rng;
mod rotating_lidar;
mod route_sampler;
mod scenes;
mod simulation;
mod slip;
mod timed_path;
mod world;

pub use crate::runtime::simulation_settings::{
    DriveDynamics, Fixes, Lidar, OdometryNoise, PedestrianSettings, Slip,
};
pub use drive::SimBase;
pub use error::SimError;
pub use fault_injection::FaultInjection;
pub use fixes::FixSource;
pub use lidar::LidarReturn;
pub use moving_obstacle::{MovingObstacle, SpawnTrigger};
pub use moving_obstacles::{MovingObstacles, YIELD_GAP_M, YIELD_TIMEOUT_S};
pub use pedestrian_spawner::PedestrianSpawner;
pub use rotating_lidar::RotatingLidar;
pub use scenes::{Scene, crossing, dead_end, roadway, scenes};
pub use simulation::Simulation;
pub use timed_path::TimedPath;
pub use world::World;
