//! The messages, a file for each kind.

mod command;
mod diagnostics;
mod map;
mod markers;
mod odometry;
mod plan;
mod scan;
mod tick;
mod transforms;

pub use command::command;
pub use diagnostics::{Status, diagnostics};
pub use map::{map, map_cells};
pub use markers::{FAN, markers};
pub use odometry::odometry;
pub use plan::plan;
pub use scan::scan;
pub use tick::{Tick, tick};
pub use transforms::transforms;
