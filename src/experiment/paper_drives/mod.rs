//! The driving half of the paper's experiments: its scenes driven from end to end in closed loop, with nothing in the way
//! and among people, and how far from the goal the robot stands in the end (figs. 12 and 13, Tables 3 and 4).
//!
//! Nothing here is timed: every number of a drive follows from its seed, on any machine and any number of threads.

mod course;
mod deviation;
mod findings;
mod printed;
mod run;
mod series;
mod table;
mod traffic;

pub use course::{Course, GOAL_YAW_RAD, START_YAW_RAD};
pub use deviation::{Deviation, Spread};
pub use printed::{PrintedDeviations, printed_table_3, printed_table_4};
pub use run::{Drive, DriveRun, MET_WITHIN_M};
pub use series::{Drives, drive_all};
pub use table::{
    ALL_SCENES, Acceptance, DriveSummary, DriveTable, MEAN_LIMIT_M, MEAN_LIMIT_RAD, PaperTable,
    drive_table,
};
pub use traffic::Traffic;
