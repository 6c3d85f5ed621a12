//! How well a robot knows where it is: the closed loop by matched scans alone, against the simulator's truth.

mod drive;
mod ground;
mod row;

pub use drive::{LocalizationCase, LocalizationPlan};
pub use row::LocalizationRow;
