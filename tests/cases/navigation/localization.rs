//! The localiser: convergence on a map, long drives with track slip, and detection of a lost pose.

mod carried;
mod changes;
mod lost;
mod odometry_fusion;
mod room;
mod stuck;
mod tours;
mod unknown_start;
