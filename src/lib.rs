//! Exact GPU-parallel local planning and hybrid navigation for inspection robots.
//!
//! A tracked robot inspects mine roadways. It finds a global path on an occupancy grid, then, many times a second,
//! chooses its speed and turn rate by the dynamic window approach: thousands of velocities rolled out, scored, the best
//! one sent to the base. The samples are evaluated in WGSL compute shaders or on the CPU, and **both return the same
//! bits**.
//!
//! The modules are rooms that data passes through in one direction, and a room uses only rooms above it:
//!
//! | room | question |
//! |---|---|
//! | [`map`] | where is free space? |
//! | [`robot`] | what is the machine? |
//! | [`localization`] | where am I? |
//! | [`global`] | which way? |
//! | [`local`] | how to move now? |
//! | [`navigator`] | when to do which? |
//! | [`base`] | what goes over the wire? |
//! | [`runtime`] | what does the robot do, tick by tick? |
//! | [`sim`] | what would happen? |
//! | [`ros`] | ROS 2: messages, Nav2 parameter files, a node |
//! | `recording` | MCAP recordings of drives and their replay (feature `mcap`) |
//! | [`mod@bench`] | how fast, and is it right? |
//! | [`experiment`] | how do worlds, settings and seeds compare? |
//! | [`report`] | what does it look like? |
//! | `playground` | a web page that decides with the GPU engine's shaders (feature `playground`) |
//!
//! [`geometry`], [`numeric`], [`digest`], [`settings`] and [`suggest`] stand above them all.
//!
//! # A robot across a room
//!
//! ```
//! use std::sync::Arc;
//! use inbye::geometry::{Point, Pose};
//! use inbye::local::CpuEngine;
//! use inbye::map::OccupancyGrid;
//! use inbye::navigator::Goal;
//! use inbye::runtime::{Config, Mission, Observer};
//! use inbye::sim::Simulation;
//!
//! let rows = [
//!     "################################",
//!     "#..............................#",
//!     "#..............................#",
//!     "#..............................#",
//!     "#..............................#",
//!     "#..............................#",
//!     "#..............................#",
//!     "#..............................#",
//!     "#..............................#",
//!     "#..............................#",
//!     "#..............##..............#",
//!     "#..............##..............#",
//!     "#..............##..............#",
//!     "#..............##..............#",
//!     "#..............##..............#",
//!     "################################",
//! ];
//! let map = Arc::new(OccupancyGrid::from_rows(&rows, 0.2, Pose::default())?);
//! let goal = Goal { position: Point::new(5.2, 1.2), yaw: None };
//! let simulation = Simulation::new(Mission::new(map, Pose::new(1.2, 1.2, 0.0), goal));
//! let engine = Box::new(CpuEngine::single_threaded());
//! let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut |_| {} };
//! let result = simulation.run(&Config::default(), engine, &mut observer)?;
//! assert!(result.reached && !result.collided);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#[cfg(feature = "sim")]
pub mod digest;
pub mod geometry;
pub mod numeric;
pub mod settings;
pub mod suggest;

pub mod map;
pub mod robot;

pub mod localization;

pub mod global;

pub mod local;

pub mod navigator;

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

#[cfg(feature = "playground")]
pub mod playground;
