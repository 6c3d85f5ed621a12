//! Accuracy of localization: closed-loop drives on matched scans alone, compared with the simulator's truth.

mod case;
mod drive;
mod error_monitor;
mod ground;
mod row;

pub use case::LocalizationCase;
pub use drive::LocalizationPlan;
pub use row::LocalizationRow;
