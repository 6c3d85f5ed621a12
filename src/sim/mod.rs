//! A world to try it in: ground, moving obstacles, a lidar, a tracked base, and the tick that ties them together.

mod config;
mod crowd;
mod drive;
mod error;
mod fixes;
mod keyframes;
mod lidar;
mod mishap;
mod mission;
mod moving;
mod noise;
mod obstacle_file;
mod obstacles;
mod odometry;
mod on_the_way;
mod ray;
mod rock;
mod scenes;
mod simulation;
mod slip;
mod to_and_fro;
mod trace;
mod troubles;
mod turning_lidar;
mod vehicle;
mod walk;
mod wander;
mod whereabouts;
mod world;

pub use config::{Config, PoseFrom, RobotConfig, WalkerSettings};
pub use crowd::Crowd;
pub use drive::{DriveDynamics, SimBase};
pub use error::SimError;
pub use fixes::{FixSource, Fixes};
pub use keyframes::Script;
pub use lidar::{Lidar, LidarReturn};
pub use mishap::Mishap;
pub use mission::{
    Mission, MissionError, MissionResult, Moment, Observer, StopError, run_mission,
    run_mission_with,
};
pub use moving::{Appears, Moving};
pub use obstacles::{Walkers, YIELD_GAP_M, YIELD_PATIENCE_S};
pub use odometry::{OdometryNoise, OdometryReading};
pub use scenes::{Scene, crossing, dead_end, roadway, scenes};
pub use slip::Slip;
pub use trace::{Trace, TraceRow};
pub use troubles::Troubles;
pub use turning_lidar::TurningLidar;
pub use vehicle::Vehicle;
pub use world::World;
