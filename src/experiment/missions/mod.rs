//! Random missions on maps.
//!
//! A map and a seed determine a mission: the robot's start, its goal and yaw, obstacles that the map does not show, and
//! moving obstacles. The same map, rules and seed give the same mission.

mod generator;
mod traffic;
mod unmapped;

use serde::Serialize;

use super::ExperimentError;
pub use generator::MissionSite;
pub use traffic::TrafficKind;

/// Lengths of missions, moving obstacles, and how often the map is wrong.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Rules {
    /// Shortest path and straight distance between start and goal, metres.
    pub min_m: f64,
    /// Longest path, metres.
    pub longest_m: f64,
    /// Largest number of moving obstacles; all numbers from zero on are equally likely.
    pub max_people: usize,
    /// Share of missions, 0 to 1, with one or two obstacles on the path that the map does not show. Another path remains.
    pub unmapped_share: f64,
}

impl Default for Rules {
    /// 4 to 60 m, up to four moving obstacles, and a correct map.
    fn default() -> Self {
        Self { min_m: 4.0, longest_m: 60.0, max_people: 4, unmapped_share: 0.0 }
    }
}

impl Rules {
    /// Checks every number.
    ///
    /// # Errors
    /// [`ExperimentError::BadValue`] names the first number out of range.
    pub fn validate(&self) -> Result<(), ExperimentError> {
        let within = |name, value: f64, least: f64, most: f64, expected| {
            if (least..=most).contains(&value) {
                return Ok(());
            }
            let key = String::from(name);
            Err(ExperimentError::BadValue { key, value: value.to_string(), expected })
        };
        within("min_m", self.min_m, 0.5, 1000.0, "0.5 to 1000")?;
        let expected = "min_m to 10000";
        within("longest_m", self.longest_m, self.min_m, 1e4, expected)?;
        let people = self.max_people as f64;
        within("max_people", people, 0.0, 100.0, "0 to 100")?;
        within("unmapped_share", self.unmapped_share, 0.0, 1.0, "0 to 1")
    }
}
