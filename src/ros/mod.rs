//! ROS 2: message types, the import of Nav2 parameters, and the robot as a node.

pub(crate) mod convert;
pub mod msg;
pub mod nav2;
pub mod node;
