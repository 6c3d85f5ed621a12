//! What can be wrong with the ground that the paper's experiments are repeated on.

use thiserror::Error;

use crate::map::MapError;

/// Ground on which nothing can be measured.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum PaperError {
    /// Too little room for paths.
    #[error(
        "the map has no {places} places that can be reached from one another {radius_m:.3} m from every obstacle: give a map \
         whose drifts are wider than twice that, or leave --mine out"
    )]
    TooNarrow {
        /// Places wanted.
        places: usize,
        /// Distance kept from obstacles, metres.
        radius_m: f64,
    },
    /// A start and a goal that no path joins.
    #[error("{task}: no way from the start to the goal {radius_m:.3} m from every obstacle")]
    NoPath {
        /// Which start and goal.
        task: String,
        /// Distance kept from obstacles, metres.
        radius_m: f64,
    },
    /// A drawing without a start or a goal.
    #[error("{scene}: the drawing has no {mark}")]
    NoMark {
        /// The scene.
        scene: String,
        /// `S` or `G`.
        mark: char,
    },
    /// A drawing that is no map.
    #[error("{scene}: {error}")]
    Drawing {
        /// The scene.
        scene: String,
        /// Why.
        error: MapError,
    },
    /// A drive that could not begin.
    #[error("{scene}, seed {seed}: the drive cannot begin: {reason}: try another --seed")]
    Drive {
        /// The scene.
        scene: String,
        /// The seed.
        seed: u64,
        /// Why.
        reason: String,
    },
}
