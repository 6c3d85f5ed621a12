//! Errors of random missions.

use thiserror::Error;

/// A mission that cannot be generated.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum MissionsError {
    /// A rule out of range.
    #[error("{name} is {value}: it must be {expected}")]
    BadRule {
        /// The rule's name.
        name: &'static str,
        /// As given.
        value: f64,
        /// What is accepted.
        expected: &'static str,
    },
    /// A map without room for any mission.
    #[error(
        "{site}: no two free places {least_m} to {longest_m} m apart along a path were found for a radius of {radius_m:.3} m: \
         use a larger map or shorter missions"
    )]
    NoRoom {
        /// The map's name.
        site: String,
        /// Shortest path, metres.
        least_m: f64,
        /// Longest path, metres.
        longest_m: f64,
        /// Distance kept from obstacles, metres.
        radius_m: f64,
    },
}
