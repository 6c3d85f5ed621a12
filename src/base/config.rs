//! Every setting of a base and of its keeper, with a documented default for each. The file format is TOML.

use serde::{Deserialize, Serialize};

use super::arduino::ArduinoSettings;
use super::ld19::LidarSettings;
use super::roboclaw::RoboClawSettings;
use super::{BaseError, BaseSettings, KeeperSettings, PlausibilitySettings};
use crate::documented::{Described, Keys, commented_toml, described, documented};
use crate::robot::TrackLimits;

documented! {
    /// What a driver must know of a base, and how the base is kept.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct BaseConfig {
        /// What the driver must know of the base.
        pub base: BaseSettings,
        /// How it is kept.
        pub keeper: KeeperSettings,
        /// A lidar on it, of `drive --lidar`.
        pub lidar: LidarSettings,
    }
}

/// Its tables, by their paths.
const TABLES: [(&str, Keys); 8] = [
    ("", BaseConfig::KEYS),
    ("base", BaseSettings::KEYS),
    ("base.tracks", TrackLimits::KEYS),
    ("base.roboclaw", RoboClawSettings::KEYS),
    ("base.arduino", ArduinoSettings::KEYS),
    ("keeper", KeeperSettings::KEYS),
    ("keeper.plausibility", PlausibilitySettings::KEYS),
    ("lidar", LidarSettings::KEYS),
];

/// What its text begins with.
const HEADING: &str = "Settings of `--base-config` with their defaults: leave out what is to stay as it is. SI units.";

impl BaseConfig {
    /// As TOML: every key with its default, and in a comment what it does. Read again it is the default.
    #[must_use]
    pub fn documented() -> String {
        commented_toml(HEADING, &TABLES, &defaults())
    }

    /// Every key with its default and what it does.
    #[must_use]
    pub fn keys() -> Vec<Described> {
        described(&TABLES, &defaults())
    }

    /// Checks every number.
    ///
    /// # Errors
    /// [`BaseError::BadConfig`] names the table and the first of its numbers that is out of range.
    pub fn validate(&self) -> Result<(), BaseError> {
        check("base", self.base.validate())?;
        check("keeper", self.keeper.validate())?;
        check("lidar", self.lidar.validate())
    }
}

fn check(table: &'static str, checked: Result<(), BaseError>) -> Result<(), BaseError> {
    checked.map_err(|error| BaseError::BadConfig {
        table,
        reason: error.to_string(),
    })
}

fn defaults() -> toml::Table {
    toml::Table::try_from(BaseConfig::default()).expect("settings are tables of plain values")
}
