//! The configuration: every setting with its default.

use core::fmt::Display;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::SimulationSettings;

use crate::global;
use crate::local::{LocalSettings, MAX_DISCS};
use crate::localization::LocalizationSettings;
use crate::map::UnknownPolicy;
use crate::navigator::{NavigatorSettings, RobotModel, RoutePlanner};
use crate::robot::{Disc, Footprint, Limits, TrackedDrive};
use crate::settings::{
    KeyDescription, Setting, SettingError, choices, commented_toml, keys, require, schema,
    setting_schema, settings,
};

settings! {
    /// The robot.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct RobotConfig {
        /// Discs that cover the robot in its own frame, 1 to 8: centre ahead `x` and to the left `y`, and `radius`, above zero,
        /// metres.
        pub footprint: Footprint = default_footprint();
        /// Distance between the tracks' centre lines.
        pub track_width_m: f64 = 0.45, ["m", above 0];
        /// Speeds and accelerations.
        pub limits: Limits = Limits { min_vel_x: -0.3, ..Limits::default() };
    }
}

/// A tracked base of about 0.7 by 0.5 m, covered by two discs.
fn default_footprint() -> Footprint {
    let discs = [0.12, -0.12].map(|x| Disc { x, y: 0.0, radius: 0.3 });
    Footprint::new(discs.to_vec()).expect("two discs with a radius")
}

impl RobotConfig {
    /// The navigator's model of the robot.
    #[must_use]
    pub fn model(&self) -> RobotModel {
        RobotModel { footprint: self.footprint.clone(), limits: self.limits }
    }

    /// Checks every number except the limits'.
    ///
    /// # Errors
    /// Names the first number out of range.
    pub fn validate(&self) -> Result<(), SettingError> {
        let discs = self.footprint.discs().len();
        require(discs <= MAX_DISCS, "number of footprint discs", discs as f64, "1 to 8")?;
        self.check_ranges()
    }

    /// The kinematics of its tracks.
    #[must_use]
    pub const fn drive(&self) -> TrackedDrive {
        TrackedDrive { track_width_m: self.track_width_m }
    }
}

/// Source of the robot's pose in the map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum PoseSource {
    /// Position fixes, which correct the odometry.
    #[default]
    Fixes,
    /// Scans of the lidar, which are matched to the map.
    Scans,
}

setting_schema! {
    PoseSource: choices::<Self>();
    UnknownPolicy: choices::<Self>();
    Footprint: json!({
        "type": "array",
        "minItems": 1,
        "maxItems": MAX_DISCS,
        "items": {
            "type": "object",
            "properties": {
                "x": { "type": "number" },
                "y": { "type": "number" },
                "radius": { "type": "number", "exclusiveMinimum": 0 },
            },
            "required": ["x", "y", "radius"],
            "additionalProperties": false,
        },
    });
}

settings! {
    /// The configuration of a robot, its navigation and its simulation. The file format is TOML.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct Config {
        /// State of unknown cells: `blocked` or `free`.
        pub unknown: UnknownPolicy = UnknownPolicy::default();
        /// Source of the robot's pose: `fixes`, position fixes that correct its odometry, or `scans`, lidar scans that are
        /// matched to the map.
        pub pose_source: PoseSource = PoseSource::default();
        /// The robot.
        pub robot: RobotConfig = RobotConfig::default();
        /// Global planning.
        pub global: global::Settings = global::Settings::default();
        /// Local planning.
        pub local: LocalSettings = LocalSettings::default();
        /// Navigation along the path.
        pub navigator: NavigatorSettings = NavigatorSettings::default();
        /// Localisation by scan matching.
        pub localization: LocalizationSettings = LocalizationSettings::default();
        /// The simulated robot and its world.
        pub simulation: SimulationSettings = SimulationSettings::default();
    }
}

/// First line of the documented TOML.
const HEADING: &str = "Settings with their defaults: leave out every key that keeps its default. SI units; x forward, y left, yaw \
    counter-clockwise.";

/// Keys of earlier versions of this file and of the base's, each with its present name.
pub const RENAMED_KEYS: [(&str, &str); 52] = [
    ("pose_from", "pose_source"),
    ("lidar", "simulation.lidar"),
    ("dynamics", "simulation.dynamics"),
    ("odometry", "simulation.odometry"),
    ("fixes", "simulation.fixes"),
    ("walkers", "simulation.pedestrians"),
    ("slowest", "min_speed"),
    ("fastest", "max_speed"),
    ("wander", "variation"),
    ("wander_length_m", "variation_length_m"),
    ("abilities", "features"),
    ("caution", "passive_safety"),
    ("parking_patience_s", "parking_timeout_s"),
    ("stop_s", "waypoint_pause_s"),
    ("least_lookahead_m", "min_lookahead_m"),
    ("check_ahead_m", "path_check_distance_m"),
    ("turn_in_place_from", "rotate_in_place_from"),
    ("turn_in_place_until", "rotate_in_place_until"),
    ("patience_s", "stuck_patience_s"),
    ("senses_timeout_s", "scan_timeout_s"),
    ("senses_patience_s", "sensor_fault_patience_s"),
    ("lost_patience_s", "localization_patience_s"),
    ("shorter_share", "min_shortcut_share"),
    ("give_up_after_s", "movement_time_allowance"),
    ("backing_speed", "escape_speed"),
    ("start_sigma_m", "initial_sigma_m"),
    ("start_sigma_rad", "initial_sigma_rad"),
    ("slip_sigma", "distance_scale_sigma"),
    ("turn_sigma", "turn_scale_sigma"),
    ("way_sigma_m", "distance_sigma_m"),
    ("outlier_m", "outlier_distance_m"),
    ("least_information", "min_information"),
    ("least_returns", "min_returns"),
    ("least_agreement", "min_agreement"),
    ("most_through", "max_through_walls"),
    ("lost_after", "lost_after_scans"),
    ("found_agreement", "relocalized_agreement"),
    ("found_after", "relocalized_after_scans"),
    ("search_radius_m", "relocalization_radius_m"),
    ("keeper", "supervisor"),
    ("plan_within_s", "target_timeout_s"),
    ("first_pause_s", "reconnect_min_s"),
    ("longest_pause_s", "reconnect_max_s"),
    ("plausibility", "fault_detector"),
    ("sure_to_move", "motion_threshold_m_s"),
    ("runaway_speed", "runaway_margin_m_s"),
    ("slip_rate", "slip_rate_rad_s"),
    ("late_s", "command_delay_s"),
    ("answer_within_s", "answer_timeout_s"),
    ("tries", "max_attempts"),
    ("poll_every_s", "poll_period_s"),
    ("silent_after_s", "timeout_s"),
];

/// A table of a configuration with a setting out of range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("[{table}] {reason}")]
#[non_exhaustive]
pub struct ConfigError {
    /// Path of the table.
    pub table: &'static str,
    /// The setting, its value and its range.
    pub reason: String,
}

impl Config {
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
    pub fn schema() -> Value {
        schema::<Self>(HEADING)
    }

    /// Creates the planner of global paths for this robot, on maps of a resolution in metres.
    #[must_use]
    pub fn route_planner(&self, resolution_m: f64) -> RoutePlanner {
        RoutePlanner::new(&self.robot.footprint, &self.navigator, self.global.clone(), resolution_m)
    }

    /// Checks every number.
    ///
    /// # Errors
    /// [`ConfigError`] names the first table and key out of range.
    pub fn validate(&self) -> Result<(), ConfigError> {
        in_table("robot.limits", self.robot.limits.validate())?;
        in_table("robot", self.robot.validate())?;
        in_table("global", self.global.validate())?;
        in_table("local.weights", self.local.weights.validate())?;
        in_table("local", self.local.validate())?;
        in_table("navigator", self.navigator.validate())?;
        in_table("localization", self.localization.validate())?;
        let simulation = &self.simulation;
        in_table("simulation.lidar", simulation.lidar.validate())?;
        in_table("simulation.dynamics", simulation.dynamics.validate())?;
        in_table("simulation.dynamics.slip", simulation.dynamics.slip.validate())?;
        in_table("simulation.odometry", simulation.odometry.validate())?;
        in_table("simulation.fixes", simulation.fixes.validate())?;
        in_table("simulation.pedestrians", simulation.pedestrians.validate())
    }
}

fn in_table(table: &'static str, result: Result<(), impl Display>) -> Result<(), ConfigError> {
    result.map_err(|error| ConfigError { table, reason: error.to_string() })
}
