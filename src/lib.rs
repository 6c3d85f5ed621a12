//! Exact GPU-parallel local planning and hybrid navigation for inspection robots.
pub mod base;
pub mod bench;
pub mod geometry;
pub mod global;
pub mod local;
pub mod map;
pub mod navigator;
pub mod numeric;
pub mod report;
pub mod robot;
pub mod sim;
