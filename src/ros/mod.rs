//! ROS 2: message types, the import of Nav2 parameters, and the robot as a node.

mod cdr;
mod convert;
mod markers;
pub mod msg;
pub mod nav2;
pub mod node;

#[cfg(feature = "mcap")]
pub(crate) use convert::nanoseconds;
pub(crate) use convert::{path, twist_stamped};
pub(crate) use markers::{SAMPLING, markers};
