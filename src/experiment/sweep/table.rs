//! The rows of the merged tables.

use serde::Serialize;

use super::manifest::ListedCell;
use super::{CellLatency, Label, Outcome};
use crate::bench::Columns;

/// A cell and what came of it, by the simulated clock alone.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SweepRow {
    /// The cell's name.
    #[serde(flatten)]
    pub label: Label,
    /// What came of it.
    #[serde(flatten)]
    pub outcome: Outcome,
    /// The cell's key.
    pub key: String,
}

/// A latency cell and what the wall clock said of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LatencyRow {
    /// The cell's name.
    #[serde(flatten)]
    pub label: Label,
    /// What the clock said.
    #[serde(flatten)]
    pub latency: CellLatency,
    /// The cell's key.
    pub key: String,
}

impl SweepRow {
    pub(super) fn new(listed: &ListedCell, outcome: &Outcome) -> Self {
        Self {
            label: listed.label.clone(),
            outcome: outcome.clone(),
            key: listed.key.clone(),
        }
    }
}

impl LatencyRow {
    pub(super) fn new(listed: &ListedCell, latency: &CellLatency) -> Self {
        Self {
            label: listed.label.clone(),
            latency: latency.clone(),
            key: listed.key.clone(),
        }
    }
}

impl Columns for SweepRow {
    const COLUMNS: &[&str] = &[
        "kind",
        "world",
        "config",
        "weights",
        "vx_samples",
        "vtheta_samples",
        "engine",
        "seed",
        "latency",
        "result",
        "contact",
        "time_s",
        "travelled_m",
        "min_clearance_m",
        "optimal_time_s",
        "score",
        "plans",
        "ticks",
        "trace_digest",
        "reason",
        "key",
    ];
}

impl Columns for LatencyRow {
    const COLUMNS: &[&str] = &[
        "kind",
        "world",
        "config",
        "weights",
        "vx_samples",
        "vtheta_samples",
        "engine",
        "seed",
        "threads",
        "ticks",
        "tick_p50_ms",
        "tick_p95_ms",
        "tick_p99_ms",
        "tick_max_ms",
        "ran_on",
        "machine",
        "key",
    ];
}

/// What the values of a column are.
#[cfg(feature = "parquet")]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ColumnKind {
    Text,
    Whole,
    Real,
    Truth,
}

/// What the values of the column of this name are, in either table.
#[cfg(feature = "parquet")]
pub(super) fn kind_of(column: &str) -> ColumnKind {
    match column {
        "vx_samples" | "vtheta_samples" | "seed" | "plans" | "ticks" | "threads" => {
            ColumnKind::Whole
        }
        "time_s" | "travelled_m" | "min_clearance_m" | "optimal_time_s" | "score"
        | "tick_p50_ms" | "tick_p95_ms" | "tick_p99_ms" | "tick_max_ms" => ColumnKind::Real,
        "latency" => ColumnKind::Truth,
        _ => ColumnKind::Text,
    }
}
