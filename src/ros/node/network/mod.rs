//! DDS in a separate process.
//!
//! A message from the network must not end the process that stops the robot. The control process has the navigator and no sockets;
//! the network process has DDS and a memory limit. Two pipes connect them, with frames of bounded length. If the network
//! process dies, hangs or is starved, the control process commands zero and starts it again. If the control process dies or
//! hangs, the network process publishes zero.

#[cfg(feature = "ros2")]
mod bridge;
mod frame;
mod link;
mod process;
mod restart;
mod watchdog;

#[cfg(feature = "ros2")]
pub use bridge::run_bridge;
pub use frame::{FromNetwork, ToNetwork, read_frame, write_frame};
pub use link::{LinkEvents, NetworkLink, NetworkStats};
pub use watchdog::CommandWatchdog;
