//! The control loop of a robot on a mission: configuration, the interface of a robot, ticks, and the trace of a drive.

mod config;
mod contact;
mod encounters;
pub mod hardware;
mod lidar_data;
mod map_update;
mod mission;
mod mission_end;
mod mission_run;
mod obstacle_gap;
pub(crate) mod plant_settings;
mod pose_estimator;
mod preparation;
mod robot_interface;
pub(crate) mod simulation_settings;
mod start_pose;
mod toml_text;
mod trace;
mod zone_compliance;

pub use config::{Config, NodeConfig, PoseSource, RobotConfig, renamed_keys};
pub use contact::{Contact, TouchedBody};
pub use encounters::{Encounters, MET_WITHIN_M};
pub(crate) use lidar_data::CompensatedScan;
pub use lidar_data::LidarData;
#[cfg(feature = "ros")]
pub(crate) use map_update::{ContradictedMap, MapUpdate};
pub use mission::{
    Decider, EarlyEnd, FaultEvents, Mission, MissionError, MissionResult, Observer, StopError,
    TickEvent, run_mission,
};
pub use mission_end::MissionEnd;
pub use mission_run::MissionRun;
pub use obstacle_gap::ObstacleGap;
pub use plant_settings::{PlantKind, PlantRanges};
#[cfg(feature = "ros")]
pub(crate) use preparation::Preparation;
pub use robot_interface::{GroundTruth, OdometryReading, Robot, SensorData};
pub use simulation_settings::SimulationSettings;
#[cfg(feature = "experiment")]
pub(crate) use start_pose::check_start;
#[cfg(feature = "experiment")]
pub(crate) use toml_text::merge_tables;
pub use toml_text::{TomlError, parse_toml};
#[doc(hidden)]
pub use toml_text::{is_other_variant, plain_message};
pub use trace::{Trace, TraceRow};
pub use zone_compliance::ZoneCompliance;
