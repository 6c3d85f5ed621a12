//! The robot as a node among ROS 2 nodes: map, scan, odometry and goal in; velocity, plan and markers out.
//!
//! [`NodeCore`] has no sockets, threads or clocks: it takes messages with the times at which they came, and says at each
//! tick what to publish. With the feature `ros2`, `dds` carries both over DDS, without a ROS installation.

mod arrived;
#[cfg(feature = "ros2")]
pub mod dds;
mod error;
mod frames;
mod heard;
mod markers;
mod node_core;
mod plane;
pub mod published;
mod scan;
mod shared_engine;
mod standstill;
mod tally;
mod told;

pub use arrived::{Arrived, Topic};
pub use error::{MessageError, NodeError};
pub use frames::Frames;
pub use node_core::{NodeCore, NodeSettings};
pub use published::Published;
pub use standstill::Missing;
pub use tally::Tally;
