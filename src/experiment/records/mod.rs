//! Records read back: a CSV file of a benchmark is recognised by its columns.

mod error;
mod read;

use super::barn::BarnRow;
use super::dynabarn::DynaBarnRow;
use super::missions::MissionRow;
use super::sweep::SweepGroup;
use super::{AblationRow, ClosedLoopRow};
use crate::bench::{DensityRow, QualityRow};

pub use error::RecordError;
pub use read::read_record;

/// The rows of a file, in its order.
#[derive(Clone, Debug, PartialEq)]
pub enum Rows {
    /// Latencies of `bench density --record`.
    Density(Vec<DensityRow>),
    /// Regrets of `bench density --record-quality`.
    Quality(Vec<QualityRow>),
    /// Missions of `bench density --record-missions`, taken together for each sampling.
    ClosedLoop(Vec<ClosedLoopRow>),
    /// Runs of `bench barn --record`.
    Barn(Vec<BarnRow>),
    /// Runs of `bench dynabarn --record`.
    DynaBarn(Vec<DynaBarnRow>),
    /// Missions of `bench soak --record`.
    Soak(Vec<MissionRow>),
    /// Missions of `bench ablation --record`, taken together for each variant.
    Ablation(Vec<AblationRow>),
    /// Groups of `sweep merge`.
    Sweep(Vec<SweepGroup>),
}

/// What a file held.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Its rows.
    pub rows: Rows,
    /// Digests of the settings that its runs were made with, each once; none where it does not tell.
    pub settings: Vec<String>,
}

impl Rows {
    /// What it is a record of, in words.
    #[must_use]
    pub const fn what(&self) -> &'static str {
        match self {
            Self::Density(_) => "latencies",
            Self::Quality(_) => "regrets",
            Self::ClosedLoop(_) => "missions with several samplings",
            Self::Barn(_) => "BARN runs",
            Self::DynaBarn(_) => "DynaBARN runs",
            Self::Soak(_) => "missions of a soak",
            Self::Ablation(_) => "missions of an ablation",
            Self::Sweep(_) => "groups of a sweep",
        }
    }
}
