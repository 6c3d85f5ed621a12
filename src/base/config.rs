//! All settings of a base, its supervisor and its lidar, each with a documented default. The file format is TOML.

use serde::{Deserialize, Serialize};

use super::ld19::LidarSettings;
use super::{BaseError, BaseSettings, SupervisorSettings};
use crate::settings::{KeyDescription, commented_toml, keys, schema, settings};

settings! {
    /// Settings of a base, its supervisor and its lidar.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct BaseConfig {
        /// Tracks, wiring and protocol of the base.
        pub base: BaseSettings = BaseSettings::default();
        /// Command rate, timeouts and fault detection.
        pub supervisor: SupervisorSettings = SupervisorSettings::default();
        /// Mounting and timeout of an LD19 lidar on the base, for `drive --lidar`.
        pub lidar: LidarSettings = LidarSettings::default();
    }
}

/// The first line of the documented TOML.
const HEADING: &str =
    "Settings of a base with their defaults: leave out every key that keeps its default. SI units.";

impl BaseConfig {
    /// Returns TOML with every key, its default and a comment. Parsing it gives the default configuration.
    #[must_use]
    pub fn documented() -> String {
        commented_toml::<Self>(HEADING)
    }

    /// Returns every key with its default and description.
    #[must_use]
    pub fn keys() -> Vec<KeyDescription> {
        keys::<Self>()
    }

    /// Returns the JSON Schema (draft 2020-12) of the file.
    #[must_use]
    pub fn schema() -> serde_json::Value {
        schema::<Self>(HEADING)
    }

    /// Checks every number.
    ///
    /// # Errors
    /// [`BaseError::BadConfig`] names the table and its first number out of range.
    pub fn validate(&self) -> Result<(), BaseError> {
        in_table("base.tracks", self.base.tracks.validate().map_err(BaseError::from))?;
        in_table("base.roboclaw", self.base.roboclaw.validate())?;
        in_table("base.arduino", self.base.arduino.validate())?;
        in_table("base", self.base.validate())?;
        in_table("supervisor.fault_detector", self.supervisor.fault_detector.validate())?;
        in_table("supervisor", self.supervisor.validate())?;
        in_table("lidar", self.lidar.validate())
    }
}

fn in_table(table: &'static str, result: Result<(), BaseError>) -> Result<(), BaseError> {
    result.map_err(|error| BaseError::BadConfig { table, reason: error.to_string() })
}
