//! DDS in a process of its own.
//!
//! A message from the network must not end the part that stops the robot. The control process has the navigator and no sockets;
//! the network process has DDS and a memory limit. Two pipes connect them, with frames of bounded length. Where the network
//! process dies, hangs or is starved, the control process commands zero and starts it again; where the control process dies or
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
