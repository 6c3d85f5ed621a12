//! The paper's driving experiments: its scenes driven in closed loop without and among people, and the deviations of the
//! final pose from the goal (figs. 12 and 13, Tables 3 and 4).
//!
//! Every figure of a drive follows from its seed, on any machine and any number of threads.

mod course;
mod deviation;
mod findings;
mod table;

pub use course::{Course, TRAFFIC, drive_worlds};
pub use deviation::{Deviation, PublishedDeviations, Spread, published_table_3, published_table_4};
pub use table::{
    ALL_SCENES, Acceptance, DriveSummary, DriveTable, MEAN_LIMIT_M, MEAN_LIMIT_RAD, MET_WITHIN_M,
    PaperTable, drive_table, scene,
};
