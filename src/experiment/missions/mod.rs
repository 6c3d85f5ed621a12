//! Random missions on maps.
//!
//! A map and a seed determine a mission: the robot's start, its goal and yaw, obstacles that the map does not show, and
//! moving obstacles. The same map, rules and seed give the same mission.

mod flood_fill;
mod generator;
mod rules;
mod site;
mod traffic;
mod unmapped;

use thiserror::Error;

pub use rules::Rules;
pub use site::MissionSite;
pub use traffic::TrafficKind;

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
