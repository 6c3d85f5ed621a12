//! A world to try it in: ground, moving obstacles, a lidar, a tracked base, and the tick that ties them together.

mod trace;

pub use trace::{Trace, TraceRow};
