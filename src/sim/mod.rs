//! A simulated robot and its world: ground, moving obstacles, a lidar, a tracked base, and injected faults.

mod drive;
pub(crate) mod error;
pub(crate) mod fault_injection;
pub(crate) mod fixes;
mod lidar;
mod mine_map;
mod moving_obstacle;
mod moving_obstacles;
mod obstacle_file;
mod odometry;
mod on_the_way;
mod patrol;
mod pedestrian_spawner;
mod random_waypoint;
mod ray;
mod rng;
mod rotating_lidar;
mod route_sampler;
mod scenes;
mod slip;
mod timed_path;
mod world;

pub use drive::{DriveDynamics, SimBase};
pub use error::SimError;
pub use fault_injection::FaultInjection;
pub use fixes::{FixSource, Fixes};
pub use lidar::{Lidar, LidarReturn};
pub use moving_obstacle::{MovingObstacle, SpawnTrigger};
pub use moving_obstacles::{MovingObstacles, YIELD_GAP_M, YIELD_TIMEOUT_S};
pub use odometry::OdometryNoise;
pub use pedestrian_spawner::PedestrianSpawner;
pub use rotating_lidar::RotatingLidar;
pub use scenes::{Scene, crossing, dead_end, roadway, scenes};
pub use slip::Slip;
pub use timed_path::TimedPath;
pub use world::World;

use crate::local::Engine;
use crate::runtime::{Config, Mission, MissionError, MissionResult, Observer, run_mission};

/// Runs a mission with the simulated base to its end: the goal, contact, a fault or the time limit.
///
/// # Errors
/// When the world cannot be built or there is no path to begin with.
pub fn simulate_mission(
    mission: &Mission,
    config: &Config,
    engine: Box<dyn Engine>,
    observer: &mut Observer<'_>,
) -> Result<MissionResult, MissionError> {
    config.validate()?;
    let mut base = SimBase::new(
        config.robot.drive(),
        config.robot.limits,
        config.dynamics,
        config.odometry,
        mission.start,
        mission.seed,
    )?;
    run_mission(mission, config, engine, &mut base, observer)
}
