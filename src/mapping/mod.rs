//! Maps from lidar logs.

mod log_scans;
mod render;

pub use log_scans::{LogScan, log_scans};
pub use render::{MAP_RESOLUTION_M, render};
