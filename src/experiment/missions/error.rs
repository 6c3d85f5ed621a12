//! What can be wrong with random missions.

use thiserror::Error;

use crate::local::EngineError;
use crate::sim::SimError;

/// Missions that cannot be drawn or driven.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum MissionsError {
    /// A rule out of range.
    #[error("{name} is {value}: it must be {expected}")]
    BadRule {
        /// Its name.
        name: &'static str,
        /// As given.
        value: f64,
        /// What would be accepted.
        expected: &'static str,
    },
    /// A map without room for any mission.
    #[error(
        "{site}: no two free places {least_m} to {longest_m} m apart along a path were found for a radius of {radius_m:.3} m: \
         name a map with more room"
    )]
    NoRoom {
        /// The map's name.
        site: String,
        /// Shortest path wanted, metres.
        least_m: f64,
        /// Longest path wanted, metres.
        longest_m: f64,
        /// Distance kept from obstacles, metres.
        radius_m: f64,
    },
    /// A mission that cannot be begun.
    #[error("{site}, seed {seed}: {error}")]
    Sim {
        /// The map's name.
        site: String,
        /// The mission's seed.
        seed: u64,
        /// Why.
        error: SimError,
    },
    /// An engine that cannot be opened.
    #[error(transparent)]
    Engine(#[from] EngineError),
}
