//! An exact, GPU-parallel local planner and navigator for inspection robots.
//!
//! A robot plans a global path on an occupancy grid. Then, in each control period, it chooses its speed and turn rate by the
//! dynamic window approach (DWA). WGSL compute shaders or the CPU evaluate the samples, and **all engines return the same bits**.
//!
//! # What to call
//!
//! | task | start with |
//! |---|---|
//! | read or build a map | [`map::load`], [`map::OccupancyGrid::from_rows`] |
//! | plan a global path | [`navigator::RoutePlanner`], or [`global::plan`] on free space of your own |
//! | take one decision | [`local::Problem::new`], [`local::open_engine`], [`local::Engine::decide`] |
//! | navigate among unmapped and moving obstacles | [`navigator::Navigator`]: an observation in, a command out |
//! | estimate the pose from scans | [`localization::Localizer`] |
//! | drive a real base | `runtime::hardware::SerialLine` and `runtime::run_mission` (feature `serial`) |
//! | simulate a drive | `sim::Simulation` (feature `sim`) |
//! | read a lidar log, make a map from it | `lidar_log::LidarLog`, `mapping::map_log` (feature `logs`) |
//! | record and replay | `recording` (feature `mcap`) |
//! | run experiments | `experiment` (feature `experiment`) |
//!
//! Units are SI. Axes are those of REP-103: x forward, y left, yaw counter-clockwise. Without features the crate is the planner alone;
//! each feature only adds. Settings have defaults, and a method sets each key: `LocalSettings::default().vx_samples(15)`.
//!
//! # One decision
//!
//! ```
//! use inbye::geometry::{Point, Pose, Twist};
//! use inbye::local::{ClearanceField, EngineChoice, Problem, open_engine};
//! use inbye::map::{OccupancyGrid, UnknownPolicy};
//! use inbye::robot::Footprint;
//!
//! let rows = [".....#......", "............", ".....#......"];
//! let grid = OccupancyGrid::from_rows(&rows, 1.0, Pose::default())?;
//! let field = ClearanceField::new(&grid.obstacles(UnknownPolicy::Blocked))?;
//! let (pose, twist) = (Pose::new(3.0, 1.2, 0.2), Twist::new(0.5, 0.0));
//! let problem = Problem::new(field, &Footprint::round(0.3)?, pose, twist, Point::new(9.0, 1.5));
//!
//! let mut selected = open_engine(&EngineChoice::Cpu, 1)?;
//! let decision = selected.engine.decide(&problem)?;
//! assert!(decision.command().linear > 0.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#[cfg(feature = "sim")]
#[doc(hidden)]
pub mod digest;
pub mod geometry;
pub mod input_file;
#[doc(hidden)]
pub mod numeric;
pub mod settings;
#[doc(hidden)]
pub mod suggest;

pub mod map;
pub mod robot;

#[cfg(feature = "logs")]
pub mod lidar_log;

#[cfg(feature = "logs")]
pub mod trajectory;

pub mod localization;

#[cfg(feature = "logs")]
pub mod mapping;

pub mod global;

pub mod local;

pub mod navigator;

#[cfg(feature = "sim")]
pub mod external;

#[cfg(feature = "sim")]
pub mod base;

#[cfg(feature = "sim")]
pub mod runtime;

#[cfg(feature = "sim")]
pub mod sim;

#[cfg(feature = "ros")]
pub mod ros;

#[cfg(feature = "mcap")]
pub mod recording;

#[cfg(feature = "experiment")]
pub mod bench;

#[cfg(feature = "experiment")]
pub mod experiment;

#[cfg(feature = "report")]
pub mod report;

#[cfg(feature = "server")]
mod server;

#[cfg(feature = "server")]
pub mod live;

#[cfg(feature = "playground")]
pub mod playground;

#[cfg(feature = "cli")]
mod cli;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub use cli::{Invocation, ReportFolder, run_program};

// The command line names the library as its users do.
#[cfg(feature = "cli")]
extern crate self as inbye;
