//! Repeats the paper's tables and figures of global paths. Its variants and ours use the same maps in the same run; a
//! breakdown shows the effect of each step.
//!
//! The times include searching, pruning and smoothing. All variants use the same free cells, which are computed before.

mod ablation;
mod ascii_maps;
mod error;
mod farthest_point_sampling;
mod findings;
mod measure;
mod mine;
mod published;
mod reduction;
mod search;
mod shortest;
mod site;
mod tables;
mod variants;

pub use ablation::{Breakdown, STEPS, Step, StepRow, breakdowns, step_rows};
pub use error::PaperError;
pub use findings::{acceptance, literal, origin, theta};
pub use measure::{Run, StagePath, TaskRuns, Times, measure};
pub use mine::made_mine;
pub use published::{PublishedRow, published_table_1, published_table_2};
pub use reduction::{Measure, Reduced, Reduction, published_reduction, targets};
pub use search::{LITERAL_K, SMALL_K, Search, Stage};
pub use site::{Site, Task};
pub use tables::{AblationTable, PathTable, path_tables};
pub use variants::{
    PathRow, StageMs, THETAS, TRADITIONAL, VARIANTS, Variant, label_of, path_rows, reductions,
};

/// All searches of the tables, in an order in which none benefits from the one before.
pub const SEARCHES: [Search; 9] = [
    Search::Manhattan,
    Search::Euclid,
    Search::Theta(30.0),
    Search::Theta(45.0),
    Search::Theta(60.0),
    Search::Improved,
    Search::Literal(LITERAL_K),
    Search::Literal(SMALL_K),
    Search::JumpPoints,
];

/// The searches in the tables of the mine.
pub const MINE_SEARCHES: [Search; 7] = [
    Search::Manhattan,
    Search::Euclid,
    Search::Theta(45.0),
    Search::Improved,
    Search::Literal(LITERAL_K),
    Search::Literal(SMALL_K),
    Search::JumpPoints,
];
