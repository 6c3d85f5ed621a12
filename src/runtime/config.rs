//! Every setting of a run, with a documented default for each. The file format is TOML.

use core::fmt::Display;

use serde::{Deserialize, Serialize};

use crate::documented::{Described, Keys, commented_toml, described, documented};
use crate::global;
use crate::local::{LocalSettings, MAX_DISCS, Weights};
use crate::localization::LocalizationSettings;
use crate::map::UnknownPolicy;
use crate::navigator::{NavigatorFeatures, NavigatorSettings, RobotModel, RoutePlanner};
use crate::robot::{Disc, Footprint, Limits, TrackedDrive};
use crate::sim::error::{above_zero, require};
use crate::sim::{DriveDynamics, Fixes, Lidar, OdometryNoise, PedestrianSpawner, SimError, Slip};

documented! {
    /// The robot as a configuration describes it.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct RobotConfig {
        /// Discs that cover it, in its own frame, 1 to 8: centre ahead `x` and to the left `y`, and `radius`, above zero,
        /// metres.
        pub footprint: Footprint,
        /// Distance between the tracks' centre lines, metres, above zero.
        pub track_width_m: f64,
        /// Speeds and accelerations.
        pub limits: Limits,
    }
}

impl Default for RobotConfig {
    /// A tracked base of about 0.7 by 0.5 m, covered by two discs.
    fn default() -> Self {
        let discs = [0.12, -0.12].map(|x| Disc {
            x,
            y: 0.0,
            radius: 0.3,
        });
        Self {
            footprint: Footprint::new(discs.to_vec()).expect("two discs with a radius"),
            track_width_m: 0.45,
            limits: Limits {
                min_vel_x: -0.3,
                ..Limits::default()
            },
        }
    }
}

impl RobotConfig {
    /// What the navigator needs to know.
    #[must_use]
    pub fn model(&self) -> RobotModel {
        RobotModel {
            footprint: self.footprint.clone(),
            limits: self.limits,
        }
    }

    /// Checks what is not checked as it is read; the limits check themselves.
    ///
    /// # Errors
    /// [`SimError::BadSetting`] names the first number out of range.
    pub fn validate(&self) -> Result<(), SimError> {
        let discs = self.footprint.discs().len();
        require(
            discs <= MAX_DISCS,
            "number of footprint discs",
            discs as f64,
            "1 to 8",
        )?;
        above_zero("track_width_m", self.track_width_m)
    }

    /// The kinematics of its tracks.
    #[must_use]
    pub const fn drive(&self) -> TrackedDrive {
        TrackedDrive {
            track_width_m: self.track_width_m,
        }
    }
}

documented! {
    /// Simulated people.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct PedestrianSettings {
        /// Radius of each, metres, above zero and at most 1000.
        pub radius_m: f64,
        /// Speed of the slowest, m/s, above zero and at most 1000.
        pub slowest: f64,
        /// Speed of the fastest, m/s, at least `slowest` and at most 1000.
        pub fastest: f64,
        /// Whether they stop rather than walk into the robot.
        pub yields: bool,
    }
}

impl Default for PedestrianSettings {
    fn default() -> Self {
        let PedestrianSpawner {
            radius_m,
            speed_m_s: (slowest, fastest),
            yields,
            ..
        } = PedestrianSpawner::new(0, 0);
        Self {
            radius_m,
            slowest,
            fastest,
            yields,
        }
    }
}

impl PedestrianSettings {
    /// Checks every number.
    ///
    /// # Errors
    /// [`SimError::BadSetting`] names the first that is out of range.
    pub fn validate(&self) -> Result<(), SimError> {
        for (name, value, least, expected) in [
            (
                "radius_m",
                self.radius_m,
                0.0,
                "above zero and at most 1000",
            ),
            ("slowest", self.slowest, 0.0, "above zero and at most 1000"),
            (
                "fastest",
                self.fastest,
                self.slowest.next_down(),
                "at least slowest and at most 1000",
            ),
        ] {
            require(value > least && value <= 1000.0, name, value, expected)?;
        }
        Ok(())
    }

    /// Returns a spawner of this many pedestrians.
    #[must_use]
    pub const fn spawner(&self, count: usize, seed: u64) -> PedestrianSpawner {
        let speed_m_s = (self.slowest, self.fastest);
        PedestrianSpawner {
            count,
            seed,
            radius_m: self.radius_m,
            speed_m_s,
            yields: self.yields,
        }
    }
}

/// Where a robot has its pose from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PoseSource {
    /// Simulated fixes of the true pose.
    #[default]
    Fixes,
    /// Scans matched to the map.
    Scans,
}

documented! {
    /// A whole configuration.
    #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct Config {
        /// What unknown ground counts as: `blocked` or `free`.
        pub unknown: UnknownPolicy,
        /// Where the robot has its pose from: `fixes`, simulated ones that hold its odometry to the map, or `scans`, those of its lidar
        /// matched to the map.
        pub pose_source: PoseSource,
        /// The robot.
        pub robot: RobotConfig,
        /// Global planning.
        pub global: global::Settings,
        /// Local planning.
        pub local: LocalSettings,
        /// Following the path.
        pub navigator: NavigatorSettings,
        /// The simulated lidar.
        pub lidar: Lidar,
        /// The simulated base, and how its tracks slip.
        pub dynamics: DriveDynamics,
        /// The simulated base's measurement of its own motion.
        pub odometry: OdometryNoise,
        /// Simulated fixes of the robot's pose.
        pub fixes: Fixes,
        /// Matching of scans to the map.
        pub localization: LocalizationSettings,
        /// Simulated people.
        pub pedestrians: PedestrianSettings,
    }
}

/// Its tables, by their paths.
const TABLES: [(&str, Keys); 15] = [
    ("", Config::KEYS),
    ("robot", RobotConfig::KEYS),
    ("robot.limits", Limits::KEYS),
    ("global", global::Settings::KEYS),
    ("local", LocalSettings::KEYS),
    ("local.weights", Weights::KEYS),
    ("navigator", NavigatorSettings::KEYS),
    ("navigator.features", NavigatorFeatures::KEYS),
    ("lidar", Lidar::KEYS),
    ("dynamics", DriveDynamics::KEYS),
    ("dynamics.slip", Slip::KEYS),
    ("odometry", OdometryNoise::KEYS),
    ("fixes", Fixes::KEYS),
    ("localization", LocalizationSettings::KEYS),
    ("pedestrians", PedestrianSettings::KEYS),
];

/// What its text begins with.
const HEADING: &str = "Settings of `inbye drive --config` with their defaults: leave out what is to stay as it is. SI units; \
    x forward, y left, yaw counter-clockwise.";

/// A table of a configuration with a setting out of range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("[{table}] {reason}")]
pub struct ConfigError {
    /// Path of the table.
    pub table: &'static str,
    /// The setting, its value and its range.
    pub reason: String,
}

impl Config {
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

    /// The planner of global paths for this robot, on maps of a resolution in metres.
    #[must_use]
    pub fn route_planner(&self, resolution_m: f64) -> RoutePlanner {
        RoutePlanner::new(
            &self.robot.footprint,
            &self.navigator,
            self.global.clone(),
            resolution_m,
        )
    }

    /// Checks every number, so that no run begins with one that it cannot have.
    ///
    /// # Errors
    /// [`ConfigError`] names the first table and key out of range.
    pub fn validate(&self) -> Result<(), ConfigError> {
        check("robot.limits", self.robot.limits.validate())?;
        check("robot", self.robot.validate())?;
        check("global", self.global.validate())?;
        check("local", self.local.validate())?;
        check("navigator", self.navigator.validate())?;
        check("lidar", self.lidar.validate())?;
        check("dynamics", self.dynamics.validate())?;
        check("odometry", self.odometry.validate())?;
        check("fixes", self.fixes.validate())?;
        check("localization", self.localization.validate())?;
        check("pedestrians", self.pedestrians.validate())
    }
}

fn defaults() -> toml::Table {
    toml::Table::try_from(Config::default()).expect("settings are tables of plain values")
}

fn check(table: &'static str, checked: Result<(), impl Display>) -> Result<(), ConfigError> {
    checked.map_err(|error| ConfigError {
        table,
        reason: error.to_string(),
    })
}
