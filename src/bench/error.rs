//! Errors of measurements.

use std::path::PathBuf;

use thiserror::Error;

use crate::local::{EngineError, ProblemError};
use crate::map::MapError;

/// A measurement that cannot be used.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum BenchError {
    /// A time that is not finite or below zero.
    #[error(
        "a measured time is {seconds} s: it must be finite and not below zero; take both readings from one monotonic clock"
    )]
    NotATime {
        /// As given.
        seconds: f64,
    },
    /// A problem that the engines reject.
    #[error("{which}: {error}")]
    Problem {
        /// Which problem.
        which: String,
        /// Why.
        error: ProblemError,
    },
    /// An engine without an answer.
    #[error("{which}: {error}")]
    Engine {
        /// Which problem.
        which: String,
        /// Why.
        error: EngineError,
    },
    /// An engine that does not open.
    #[error(transparent)]
    Open(#[from] EngineError),
    /// An engine's answer differs from the first engine's; its times would be meaningless.
    #[error("{which}: {engine} gave other bits than {first}: run `inbye verify`")]
    Differs {
        /// Which problem.
        which: String,
        /// The engine.
        engine: String,
        /// The first engine.
        first: String,
    },
    /// A map or a file of scenarios that cannot be used.
    #[error(transparent)]
    Map(#[from] MapError),
    /// A folder that cannot be listed.
    #[error("{}: the folder cannot be read ({reason}): check the path and its permissions", folder.display())]
    Folder {
        /// The folder.
        folder: PathBuf,
        /// The system's message.
        reason: String,
    },
    /// A folder without anything to measure.
    #[error(
        "{}: no .map file in it or below has its .map.scen or .scen next to it: name a folder that has both",
        folder.display()
    )]
    NoMaps {
        /// The folder.
        folder: PathBuf,
    },
    /// A file without a scenario.
    #[error("{}: holds no scenario: check that it is the right file", scen.display())]
    NoScenario {
        /// The file.
        scen: PathBuf,
    },
    /// Scenarios of another map.
    #[error(
        "{}: line {line}: is for a map of {} x {} cells, and {} has {} x {}: name the scenarios of this map",
        scen.display(), listed.0, listed.1, map.display(), size.0, size.1
    )]
    OtherMap {
        /// The file of scenarios.
        scen: PathBuf,
        /// The line, from one.
        line: usize,
        /// Columns and rows as listed.
        listed: (i32, i32),
        /// The file of the map.
        map: PathBuf,
        /// Its columns and rows.
        size: (i32, i32),
    },
}
