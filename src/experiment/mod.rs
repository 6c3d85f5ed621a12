//! Runs every combination of worlds, configurations and seeds in the simulator, and makes one row of each run.

mod ablation;
pub mod barn;
pub mod campaign;
mod closed_loop;
pub mod dynabarn;
mod localization;
pub mod missions;
pub mod paper_drives;
pub mod records;
mod soak;
pub mod sweep;
pub mod worlds;

pub use ablation::{ABLATION_VARIANTS, AblationRow, AblationVariant, ablation_rows};
pub use closed_loop::{ClosedLoopRow, closed_loop_of_record, closed_loop_rows, closed_loop_setups};
pub use localization::{LocalizationCase, LocalizationPlan, LocalizationRow};
pub(crate) use soak::percentile;
pub use soak::{FinalError, Part, SOAK_SETUP, SoakSummary};
