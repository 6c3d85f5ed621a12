//! How well a robot knows where it is: the closed loop by matched scans alone, against the simulator's truth.

mod case;
mod drive;
mod ground;
mod row;
mod watch;

pub use case::LocalizationCase;
pub use drive::LocalizationPlan;
pub use row::LocalizationRow;
