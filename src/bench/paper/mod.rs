//! The paper's tables and figures, repeated beside its printed values: global paths, its variants and ours on the same ground,
//! in the same run, and what each step earns.
//!
//! Times are of searching, pruning and smoothing. The free cells are there before: all variants use the same.

mod ablation;
mod drawings;
mod error;
mod findings;
mod measure;
mod mine;
mod printed;
mod reduction;
mod search;
mod shortest;
mod site;
mod spread;
mod tables;
mod variants;

pub use ablation::{Breakdown, STEPS, Step, StepRow, breakdowns, step_rows};
pub use error::PaperError;
pub use findings::{acceptance, literal, origin, theta};
pub use measure::{Run, TaskRuns, Times, Worked, measure};
pub use mine::made_mine;
pub use printed::{PrintedRow, printed_table_1, printed_table_2};
pub use reduction::{Measure, Reduced, Reduction, printed_reduction, targets};
pub use search::{LITERAL_K, SMALL_K, Search, Stage};
pub use site::{Site, Task};
pub use tables::{AblationTable, PathTable, path_tables};
pub use variants::{
    PathRow, StageMs, THETAS, TRADITIONAL, VARIANTS, Variant, label_of, path_rows, reductions,
};

/// All searches of the tables, in an order in which none profits from the one before.
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

/// Those that the tables of the mine show.
pub const MINE_SEARCHES: [Search; 7] = [
    Search::Manhattan,
    Search::Euclid,
    Search::Theta(45.0),
    Search::Improved,
    Search::Literal(LITERAL_K),
    Search::Literal(SMALL_K),
    Search::JumpPoints,
];
