//! The local planner: samples forward speeds and turn rates, scores each trajectory and chooses the best.
//!
//! [`QuantizedProblem`] turns a [`Problem`] in metres and radians into integers. An [`Engine`] evaluates them on the
//! CPU or on a GPU. **Every engine returns the same bits**: the terms of each sample, the sums that normalise them, the
//! counts and the winner. [`LocalPlanner`] runs these steps at every control tick; [`Engine::decide`] runs them once.
//!
//! The rollout, the scoring and the selection exist twice: in Rust here, and in WGSL under `shaders/`. The files and functions have
//! the same names.

mod clearance_error;
mod cpu;
mod engine;
mod engine_selection;
mod error;
mod explain;
mod failover;
mod field;
#[cfg(feature = "gpu")]
mod gpu;
mod kernel_inputs;
mod planner;
mod problem;
mod quantize;
mod rollout;
mod sample_motions;
mod sample_profile;
mod sampler;
mod score;
mod select;
mod settings;
mod shared_engine;
mod shared_engines;
mod window;

pub use clearance_error::clearance_error_m;
pub(crate) use clearance_error::step_that_overlooks;
pub use cpu::{CpuEngine, InstructionSet};
pub use engine::{
    Counts, Detail, Engine, Evaluation, SampleRecord, SampleStatus, Terms, Totals, Winner,
};
pub use engine_selection::{
    AdapterSelection, CpuEngines, EngineChoice, SelectedEngine, open_engine, open_engines,
    open_to_replay, open_with_fallback,
};
pub use error::{DecisionError, EngineError, GpuFailureKind, ProblemError};
pub use explain::{Decision, Explainer, FanArc, SampleSi, TermsSi, TrajectoryFan, WinnerSi};
#[cfg(feature = "experiment")]
pub(crate) use failover::DeviceCloser;
pub use failover::{BackgroundOpener, Failover, GpuSource, Incident, Incidents};
pub use field::ClearanceField;
#[cfg(feature = "gpu")]
pub use gpu::{Adapter, AdapterSummary, GpuEngine, adapters};
pub use planner::LocalPlanner;
#[cfg(feature = "experiment")]
pub(crate) use problem::MAX_REACH_UNITS;
pub use problem::{DecisionInput, MAX_DISCS, Normalization, Outside, Problem, Stopping, Weights};
pub use quantize::QuantizedProblem;
pub(crate) use quantize::{CLEARANCE_AND_DISC, CLEARANCE_AND_DISCS};
pub use sampler::{Sampler, SamplerInputs};
pub use settings::{LocalSettings, Sampling};
pub use shared_engine::SharedEngine;
pub use shared_engines::SharedEngines;
pub use window::{Axis, Window};

/// Parts of the kernels that the tests, the benchmarks and the playground of this package use. Not part of the API:
/// they change without notice.
#[doc(hidden)]
pub mod internals {
    pub use super::explain::evenly_spaced;
    pub use super::failover::FIRST_RETRY;
    pub use super::kernel_inputs::{
        Header, ProfileSegment, QuantizedDisc, QuantizedObstacle, TurnProfile, VxSample,
    };

    /// The vectors of the CPU engine.
    pub mod lanes {
        pub use crate::local::cpu::arithmetic::*;
        pub use crate::local::cpu::lanes::{LaneTask, Lanes, MAX_LANES, Square};
    }

    pub mod rollout {
        pub use crate::local::rollout::*;
    }

    pub mod score {
        pub use crate::local::score::*;
    }

    pub mod select {
        pub use crate::local::select::*;
    }

    /// The transport to the GPU.
    #[cfg(feature = "gpu")]
    pub mod gpu {
        pub use crate::local::gpu::batch::*;
        pub use crate::local::gpu::layout::*;
        pub use crate::local::gpu::pipelines::{PARTS, Pipeline, source};
    }
}
