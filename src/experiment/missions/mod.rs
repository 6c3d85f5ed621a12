//! Random missions on maps.
//!
//! A map and a seed determine a mission: the robot's start, its goal and yaw, obstacles that the map does not show, and
//! moving obstacles. The same map, rules and seed give the same mission.

mod error;
mod flood_fill;
mod generator;
mod rules;
mod site;
mod traffic;
mod unmapped;

pub use error::MissionsError;
pub use generator::GeneratedMission;
pub use rules::Rules;
pub use site::MissionSite;
pub use traffic::TrafficKind;
