//! Repeats the paper's tables and figures of global paths. Its variants and ours use the same maps in the same run; a
//! breakdown shows the effect of each step.
//!
//! The times include searching, pruning and smoothing. All variants use the same free cells, which are computed before.

mod ablation;
mod findings;
mod measure;
mod mine;
mod reduction;
mod search;
mod site;
mod tables;

pub use ablation::{Breakdown, StepRow, breakdowns, step_rows};
pub use findings::{acceptance, literal, origin, theta};
pub use measure::{Run, StagePath, TaskRuns, Times, measure};
pub use mine::made_mine;
pub use reduction::{
    Measure, PUBLISHED_TABLE_1, PUBLISHED_TABLE_2, PublishedRow, Reduced, Reduction,
    published_reduction, targets,
};
pub use search::{MINE_SEARCHES, SEARCHES, Search, Stage, label_of};
pub use site::{PaperError, Site, Task};
pub use tables::{AblationTable, PathRow, PathTable, StageMs, path_tables};
