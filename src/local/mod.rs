//! How to move now: thousands of (v, omega) samples rolled out, scored, the best one chosen, every tick.
//!
//! A [`Problem`] in metres and radians is prepared once as integers ([`Prepared`]); an [`Engine`] evaluates those, on
//! the CPU or on a GPU, and **every engine returns the same bits**: each sample's terms, the sums that normalise them,
//! the counts, the winner. [`LocalPlanner`] ties the steps together.
//!
//! The rollout ([`rollout`]), the scoring ([`score`]) and the choice ([`select`]) are each written twice, in Rust here
//! and in WGSL under `shaders/`, file by file under the same names.

mod contract;
mod cpu;
mod error;
mod explain;
mod failover;
mod fan;
mod field;
#[cfg(feature = "gpu")]
pub mod gpu;
mod inputs;
mod open;
mod open_to_drive;
mod planner;
mod prepare;
mod problem;
mod ranges;
pub mod rollout;
pub mod score;
pub mod select;
mod settings;
mod window;

pub use contract::{
    Counts, Detail, Engine, Evaluation, Reason, SampleRecord, Terms, Totals, Winner,
};
pub use cpu::{CpuEngine, GatherOnly, Instructions};
pub use error::{EngineError, LossKind, ProblemError};
pub use explain::{Explainer, SampleSi, TermsSi, WinnerSi};
pub use failover::{Beside, FIRST_RETRY, Failover, GpuSource, Incident, Incidents, LONGEST_RETRY};
pub use fan::{Fan, FanArc, spread};
pub use field::ClearanceField;
pub use inputs::{BodyDisc, Header, MovingBody, Speed, Turn};
pub use open::{Opened, Preference, open, open_all, open_to_compare};
pub use open_to_drive::open_to_drive;
pub use planner::{ChooseError, LocalPlanner, Situation};
pub use prepare::Prepared;
pub use problem::{Normalization, Outside, Problem, Stopping, Weights};
pub use ranges::MAX_DISCS;
pub use settings::{LocalSettings, Sampling};
pub use window::{Axis, Window};
