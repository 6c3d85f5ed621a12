//! When to do which: follow the path, replan, recover, stop.

mod mode;

pub use mode::Mode;
