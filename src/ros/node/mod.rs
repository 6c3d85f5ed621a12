//! The robot as a ROS 2 node: map, scan, odometry and goal in; velocity, plan and markers out.
//!
//! [`NodeCore`] has no sockets, threads or clocks. It takes messages with their times of arrival, and returns at each tick the
//! messages to publish. With the feature `ros2`, `dds` transports them over DDS, without a ROS installation; [`network`] keeps
//! DDS in a separate process.

mod action;
#[cfg(feature = "ros2")]
mod action_server;
mod arrival_delay;
mod conflicts;
#[cfg(feature = "ros2")]
pub mod dds;
mod diagnostics;
mod engine;
mod frames;
mod incoming;
mod latest_inputs;
mod lifecycle;
#[cfg(feature = "ros2")]
mod lifecycle_server;
mod localization;
mod names;
pub mod network;
mod node_core;
mod notices;
mod odometry_check;
#[cfg(feature = "ros2")]
mod peers;
#[cfg(feature = "ros2")]
mod pending_requests;
mod protection;
mod scan;
mod zones;

pub use action::ActionUpdate;
#[cfg(all(feature = "mcap", feature = "logs"))]
pub(crate) use frames::{Frames, NoPose};
pub use incoming::IncomingMessage;
#[cfg(all(feature = "mcap", feature = "logs"))]
pub(crate) use incoming::{frame_name, planar_pose};
pub use lifecycle::LifecycleState;
pub use names::{NameError, NodeNames};
pub use node_core::{NodeCore, NodeSettings, Outgoing};
pub use notices::NodeStats;
#[cfg(all(feature = "mcap", feature = "logs"))]
pub(crate) use scan::{laser_scan, level_range, timed_scan};
