//! What can be wrong with a world that is to be driven.

use thiserror::Error;

use crate::map::MapError;
use crate::sim::SimError;

/// A run that cannot be made.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum WorldError {
    /// A world too large for one grid.
    #[error("world {world}: {error}")]
    Ground {
        /// The world.
        world: u32,
        /// Why.
        error: MapError,
    },
    /// A run that cannot be begun.
    #[error("world {world}: {error}")]
    Sim {
        /// The world.
        world: u32,
        /// Why.
        error: SimError,
    },
}
