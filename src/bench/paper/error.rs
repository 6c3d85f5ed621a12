//! Errors of the paper's experiments.

use thiserror::Error;

use crate::map::MapError;

/// A map or drive that cannot be used.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum PaperError {
    /// Too little room for paths.
    #[error(
        "the map has no {places} connected places {radius_m:.3} m from every obstacle: use a map whose roadways are wider \
         than twice that"
    )]
    TooNarrow {
        /// Number of places.
        places: usize,
        /// Distance kept from obstacles, metres.
        radius_m: f64,
    },
    /// A start and a goal without a path.
    #[error("{task}: no path from the start to the goal {radius_m:.3} m from every obstacle")]
    NoPath {
        /// The task.
        task: String,
        /// Distance kept from obstacles, metres.
        radius_m: f64,
    },
    /// A text map without a start or a goal.
    #[error("{scene}: the text map has no {mark}")]
    NoMark {
        /// The scene.
        scene: String,
        /// `S` or `G`.
        mark: char,
    },
    /// A text that is no map.
    #[error("{scene}: {error}")]
    AsciiMap {
        /// The scene.
        scene: String,
        /// Why.
        error: MapError,
    },
    /// A drive that cannot start.
    #[error("{scene}, seed {seed}: the drive cannot start: {reason}: try another seed")]
    Drive {
        /// The scene.
        scene: String,
        /// The seed.
        seed: u64,
        /// Why.
        reason: String,
    },
}
