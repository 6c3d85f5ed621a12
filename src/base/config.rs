//! All settings of a base, its supervisor and its lidar, each with a documented default. The file format is TOML.

use serde::{Deserialize, Serialize};

use super::arduino::ArduinoSettings;
use super::ld19::LidarSettings;
use super::roboclaw::RoboClawSettings;
use super::{BaseError, BaseSettings, FaultDetectorSettings, SupervisorSettings};
use crate::documented::{Described, Keys, commented_toml, described, documented};
use crate::robot::TrackLimits;

documented! {
    /// Settings of a base, its supervisor and its lidar.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct BaseConfig {
        /// Tracks, wiring and protocol of the base.
        pub base: BaseSettings,
        /// Command rate, timeouts and fault detection.
        pub supervisor: SupervisorSettings,
        /// Mounting and timeout of an LD19 lidar on the base, for `drive --lidar`.
        pub lidar: LidarSettings,
    }
}

/// The tables by path.
const TABLES: [(&str, Keys); 8] = [
    ("", BaseConfig::KEYS),
    ("base", BaseSettings::KEYS),
    ("base.tracks", TrackLimits::KEYS),
    ("base.roboclaw", RoboClawSettings::KEYS),
    ("base.arduino", ArduinoSettings::KEYS),
    ("supervisor", SupervisorSettings::KEYS),
    ("supervisor.fault_detector", FaultDetectorSettings::KEYS),
    ("lidar", LidarSettings::KEYS),
];

/// The first line of the documented TOML.
const HEADING: &str = "Settings of `--base-config` with their defaults: leave out every key that keeps its default. SI units.";

impl BaseConfig {
    /// Returns TOML with every key, its default and a comment. Parsing it gives the default configuration.
    #[must_use]
    pub fn documented() -> String {
        commented_toml(HEADING, &TABLES, &defaults())
    }

    /// Returns every key with its default and description.
    #[must_use]
    pub fn keys() -> Vec<Described> {
        described(&TABLES, &defaults())
    }

    /// Checks every number.
    ///
    /// # Errors
    /// [`BaseError::BadConfig`] names the table and its first number out of range.
    pub fn validate(&self) -> Result<(), BaseError> {
        in_table("base", self.base.validate())?;
        in_table("supervisor", self.supervisor.validate())?;
        in_table("lidar", self.lidar.validate())
    }
}

fn in_table(table: &'static str, result: Result<(), BaseError>) -> Result<(), BaseError> {
    result.map_err(|error| BaseError::BadConfig {
        table,
        reason: error.to_string(),
    })
}

fn defaults() -> toml::Table {
    toml::Table::try_from(BaseConfig::default()).expect("settings are tables of plain values")
}
