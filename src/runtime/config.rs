//! The configuration: every setting with its default.

use serde::{Deserialize, Serialize};
use serde_json::json;

use super::SimulationSettings;

use crate::global;
use crate::local::{Engine, LocalPlanner, LocalSettings, MAX_DISCS};
use crate::localization::LocalizationSettings;
use crate::map::{ObstacleGrid, UnknownPolicy};
use crate::navigator::{Fault, Navigator, NavigatorSettings, RobotModel, RoutePlanner, Waypoints};
use crate::robot::{Disc, Footprint, Limits, TrackedDrive};
use crate::settings::{choices, require, setting_schema, settings};

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
    rule |robot| {
        let discs = robot.footprint.discs().len();
        require(discs <= MAX_DISCS, "number of footprint discs", discs as f64, "1 to 8")
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
    heading "Settings with their defaults: leave out every key that keeps its default. SI units; x forward, y left, yaw \
        counter-clockwise."
}

/// Returns the keys of earlier versions of this file and of the base's, each with its present name.
pub fn renamed_keys() -> impl Iterator<Item = (&'static str, &'static str)> {
    include_str!("renamed_keys.txt").lines().filter_map(|line| line.split_once(' '))
}

impl Config {
    /// Creates the planner of global paths for this robot, on maps of a resolution in metres.
    #[must_use]
    pub fn route_planner(&self, resolution_m: f64) -> RoutePlanner {
        RoutePlanner::new(&self.robot.footprint, &self.navigator, self.global.clone(), resolution_m)
    }

    /// Creates the navigator of this robot on a map with the obstacles that it knows. The clock measures the first planning.
    ///
    /// # Errors
    /// No path leads to a goal.
    pub fn new_navigator(
        &self,
        known: ObstacleGrid,
        waypoints: &Waypoints,
        engine: Box<dyn Engine>,
        clock: &mut dyn FnMut() -> f64,
    ) -> Result<Navigator, Fault> {
        let route_planner = self.route_planner(known.frame().resolution_m);
        let planner = LocalPlanner::new(engine, self.local.clone());
        let (robot, settings) = (self.robot.model(), self.navigator.clone());
        Navigator::new(known, waypoints, robot, planner, route_planner, settings, clock)
    }
}
