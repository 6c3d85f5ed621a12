//! The configuration: every setting with its default.

use core::ops::RangeInclusive;

use serde::{Deserialize, Serialize};
use serde_json::json;

use super::{PlantRanges, SimulationSettings};

use crate::base::{CollisionMonitorSettings, ProtectiveLayer};
use crate::external::{ProcessController, ProcessPlanner, ProgramSettings};
use crate::geometry::{Point, Pose, Twist};
use crate::global;
use crate::local::{
    DecisionInput, Engine, LocalPlanner, LocalSettings, MAX_DISCS, ProblemError, Weights,
};
use crate::localization::LocalizationSettings;
use crate::map::UnknownPolicy;
use crate::navigator::{
    Controller, Fault, GlobalPlanner, NavigationMap, Navigator, NavigatorSettings, PlannedGoals,
    PreparedMap, RobotModel, RoutePlanner, Waypoints, ZonedMap, limits_in_zones,
};
use crate::robot::{Footprint, Limits, Polygon, TrackedDrive};
use crate::settings::{SettingError, choices, require, setting_schema, settings};

settings! {
    /// The robot.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct RobotConfig {
        /// Shape of the robot in its own frame, metres: the corners `[x, y]` of its body as in Nav2, which discs then cover. Or 1 to
        /// 8 discs, each with its centre ahead `x` and to the left `y`, and a `radius` above zero, such as
        /// `[{ x = 0.0, y = 0.0, radius = 0.26 }]`. Or a table of both, `body` and `discs`, where the discs must cover the body.
        /// Contact is judged by the body.
        pub footprint: Footprint = Footprint::covering(Polygon::default());
        /// Distance between the tracks' centre lines.
        pub track_width_m: f64 = 0.45, ["m", above 0 to 100];
        /// Speeds and accelerations.
        pub limits: Limits = Limits { min_vel_x: -0.3, ..Limits::default() };
    }
    rule |robot| {
        let discs = robot.footprint.discs().len();
        require(discs <= MAX_DISCS, "number of footprint discs", discs as f64, "1 to 8")?;
        // The navigator follows paths ahead: a robot that only turns or reverses would stand until it fails.
        let fastest = robot.limits.max_vel_x;
        require(fastest > 0.0, "max_vel_x", fastest, "above zero: the robot drives ahead along its path")
            .map_err(|error| error.in_table("limits"))
    }
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
    Footprint: footprint_schema();
}

fn footprint_schema() -> serde_json::Value {
    let corners = json!({
        "type": "array",
        "minItems": 3,
        "items": { "type": "array", "minItems": 2, "maxItems": 2, "items": { "type": "number" } },
    });
    let discs = json!({
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
    let both = json!({
        "type": "object",
        "properties": { "body": corners, "discs": discs },
        "required": ["body", "discs"],
        "additionalProperties": false,
    });
    let text = json!({ "type": "string" });
    json!({ "anyOf": [corners, text, discs, both] })
}

settings! {
    /// The ROS 2 node.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct NodeConfig {
        /// Age of a transform on `tf` from which the robot brakes. Transforms on `tf_static` do not age.
        pub transform_timeout_s: f64 = 0.3, ["s", above 0 to 10000];
        /// A stamp of a scan or of odometry may be this far in the future: clocks are never quite equal. A message with a
        /// later stamp is rejected.
        pub max_clock_ahead_s: f64 = 0.1, ["s", 0 to 10];
        /// Memory that the network process may use, on Linux. With more it is ended and started again.
        pub network_memory_mib: u32 = 1024, ["MiB", 64 to 65536];
    }
}

impl NodeConfig {
    /// The values of `control_period_s` that the node keeps, seconds. It polls its inputs every 4 ms, and takes a longer time
    /// between two ticks for a pause of its process.
    pub const PERIODS_S: RangeInclusive<f64> = 0.01..=0.25;
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
        /// The user's own program that plans global paths in place of inbye.
        pub global_planner: ProgramSettings = ProgramSettings::default();
        /// The user's own program that decides velocities in place of inbye.
        pub controller: ProgramSettings = ProgramSettings::default();
        /// Navigation along the path.
        pub navigator: NavigatorSettings = NavigatorSettings::default();
        /// The protective layer below the planner, in the sender of a real base and in simulation.
        pub collision_monitor: CollisionMonitorSettings = CollisionMonitorSettings::default();
        /// Localisation by scan matching.
        pub localization: LocalizationSettings = LocalizationSettings::default();
        /// The ROS 2 node.
        pub node: NodeConfig = NodeConfig::default();
        /// The user's own program that simulates the robot and its world in place of inbye.
        pub simulator: ProgramSettings = ProgramSettings::default();
        /// The simulated robot and its world.
        pub simulation: SimulationSettings = SimulationSettings::default();
    }
    heading "Settings with their defaults: leave out every key that keeps its default. SI units; x forward, y left, yaw \
        counter-clockwise."
    rule |config| {
        // Where the layer keeps more than the navigator, it stops the robot on paths that the navigator takes for free.
        let (navigator, layer) = (&config.navigator, &config.collision_monitor);
        let is_valid = !layer.enabled || navigator.safety_margin_m >= layer.margin_m;
        let expected = "at least that of the protective layer, margin_m in [collision_monitor]";
        require(is_valid, "safety_margin_m", navigator.safety_margin_m, expected)
            .map_err(|error| error.in_table("navigator"))?;
        let Weights { heading, clearance, velocity, path } = config.local.weights;
        // Then all samples have one score, and the robot takes the first.
        let has_weight = heading + clearance + velocity + path > 0.0;
        let expected = "above zero where the other three weights are zero";
        require(has_weight, "heading", heading, expected)
            .map_err(|error| error.in_table("weights").in_table("local"))?;
        config.check_parking_speeds()?;
        // The sender follows a command for this time. A robot among people could not brake for them in time between two decisions:
        // it waits for them instead, for ever at 0.5 s.
        let period_s = config.local.control_period_s;
        require(period_s <= 0.3, "control_period_s", period_s, "at most 0.3 in a drive")
            .map_err(|error| error.in_table("local"))?;
        config.check_scan_age()
    }
}

/// Returns the keys of earlier versions of this file and of the base's, each with its present name.
pub fn renamed_keys() -> impl Iterator<Item = (&'static str, &'static str)> {
    include_str!("renamed_keys.txt").lines().filter_map(|line| line.split_once(' '))
}

impl Config {
    /// The largest `sensing_delay_s` with which a scan of the simulated lidar is not old by its stamp before the next one comes:
    /// otherwise the robot would stop again and again.
    pub(crate) fn largest_sensing_delay_s(&self) -> f64 {
        let SimulationSettings { lidar, stamps_sensing_delay, .. } = &self.simulation;
        if self.simulator.is_set() || !stamps_sensing_delay {
            return f64::INFINITY;
        }
        let period_s = lidar.scan_rate_hz.map_or(0.0, f64::recip);
        let layer = &self.collision_monitor;
        let layer_s = if layer.enabled { layer.source_timeout } else { f64::INFINITY };
        // Rounded for the message.
        ((self.navigator.scan_timeout_s.min(layer_s) - period_s) * 1e6).round() / 1e6
    }

    /// A parking robot that moves has at least these speeds: faster than it can drive, it jumps back and forth over its goal.
    fn check_parking_speeds(&self) -> Result<(), SettingError> {
        let (navigator, limits) = (&self.navigator, &self.robot.limits);
        let check = |name, least: f64, most: f64, expected| {
            require(least <= most, name, least, expected)
                .map_err(|error| error.with_bound(most).in_table("navigator"))
        };
        let (linear, angular) =
            (navigator.min_approach_linear_velocity, navigator.min_rotational_vel);
        let expected = "at most max_vel_x in [robot.limits]";
        check("min_approach_linear_velocity", linear, limits.max_vel_x, expected)?;
        let expected = "at most max_vel_theta in [robot.limits]";
        check("min_rotational_vel", angular, limits.max_vel_theta, expected)
    }

    /// Checks the delays against [`Self::largest_sensing_delay_s`].
    fn check_scan_age(&self) -> Result<(), SettingError> {
        let SimulationSettings { sensing_delay_s, plant_ranges, .. } = &self.simulation;
        let largest_s = self.largest_sensing_delay_s();
        if largest_s < 0.0 {
            return Err(self.too_short_scan_timeout(sensing_delay_s - largest_s));
        }
        let expected = "at most scan_timeout_s in [navigator] and source_timeout in [collision_monitor], less the time \
            between two scans";
        let check = |delay_s: f64| {
            require(delay_s <= largest_s + 1e-9, "sensing_delay_s", delay_s, expected)
                .map_err(|error| error.with_bound(largest_s))
        };
        check(*sensing_delay_s).map_err(|error| error.in_table("simulation"))?;
        // A slow lidar is no error of a file that does not set the range: its missions draw from what is left of it.
        let [_, latest_s] = plant_ranges.sensing_delay_s;
        if plant_ranges.sensing_delay_s == PlantRanges::default().sensing_delay_s {
            return Ok(());
        }
        check(latest_s).map_err(|error| error.in_table("simulation.plant_ranges"))
    }

    /// The error of the shorter timeout of scans, which no delay of the lidar meets: it lacks this time, seconds.
    fn too_short_scan_timeout(&self, lacking_s: f64) -> SettingError {
        let (timeout_s, layer) = (self.navigator.scan_timeout_s, &self.collision_monitor);
        let (table, name, timeout_s) = if layer.enabled && layer.source_timeout < timeout_s {
            ("collision_monitor", "source_timeout", layer.source_timeout)
        } else {
            ("navigator", "scan_timeout_s", timeout_s)
        };
        let expected =
            "at least 1 / scan_rate_hz in [simulation.lidar] plus sensing_delay_s in [simulation]";
        // Rounded for the message.
        let least_s = ((timeout_s + lacking_s) * 1e6).round() / 1e6;
        SettingError::new(name, timeout_s, expected).with_bound(least_s).in_table(table)
    }

    /// Creates the protective layer of this robot's sender, which sends a command in each period, seconds. It is not armed.
    ///
    /// # Errors
    /// Names the first setting out of range.
    pub fn protective_layer(&self, period_s: f64) -> Result<ProtectiveLayer, SettingError> {
        let RobotConfig { footprint, limits, .. } = &self.robot;
        ProtectiveLayer::new(self.collision_monitor.clone(), footprint, *limits, period_s)
    }

    /// The configuration for a robot in real time: the control loop never waits for a plan, and a decision has a deadline, one
    /// control period unless the settings have another.
    #[must_use]
    pub const fn in_real_time(mut self) -> Self {
        self.navigator.wait_for_plans = false;
        if self.navigator.deadline_s.is_none() {
            self.navigator.deadline_s = Some(self.local.control_period_s);
        }
        self
    }

    /// The input of one decision of this robot on a map, with its velocity and its local target: without moving obstacles, with the
    /// velocity as the last command and the target as the key node; every field can be changed afterwards. Where zones limit the
    /// speed, the limits are lower, as a navigator has them there; a robot that is faster brakes.
    ///
    /// # Errors
    /// The resolution of the map is out of range.
    pub fn decision_input<'a>(
        &'a self,
        map: &'a ZonedMap,
        pose: Pose,
        twist: Twist,
        target: Point,
    ) -> Result<DecisionInput<'a>, ProblemError> {
        let (limits, period_s) = (self.robot.limits, self.local.control_period_s);
        let in_zones = |zones| limits_in_zones(&limits, zones, &pose, &twist, period_s);
        let field = map.field(self.unknown)?;
        Ok(DecisionInput {
            limits: map.zones.as_deref().map_or(limits, in_zones),
            weights: self.local.weights,
            ..DecisionInput::new(field, &self.robot.footprint, pose, twist, target)
        })
    }

    /// Creates the planner of global paths for this robot, on maps of a resolution in metres.
    #[must_use]
    pub fn route_planner(&self, resolution_m: f64) -> RoutePlanner {
        RoutePlanner::new(&self.robot.footprint, &self.navigator, self.global.clone(), resolution_m)
    }

    /// Creates the navigator of this robot on a map, with the controller and the global planner
    /// of the settings. The clock measures the first planning.
    ///
    /// # Errors
    /// No path leads to a goal, or a program of the settings cannot be started.
    pub fn new_navigator(
        &self,
        map: impl Into<NavigationMap>,
        waypoints: &Waypoints,
        engine: Box<dyn Engine>,
        clock: &mut dyn FnMut() -> f64,
    ) -> Result<Navigator, Fault> {
        let map = map.into();
        let controller = self.new_controller(&map)?;
        self.new_navigator_with(map, waypoints, engine, controller, clock)
    }

    /// As [`Self::new_navigator`], with this controller in place of that of the settings; none for inbye's own behaviours.
    ///
    /// # Errors
    /// As [`Self::new_navigator`].
    pub fn new_navigator_with(
        &self,
        map: impl Into<NavigationMap>,
        waypoints: &Waypoints,
        engine: Box<dyn Engine>,
        controller: Option<Box<dyn Controller>>,
        clock: &mut dyn FnMut() -> f64,
    ) -> Result<Navigator, Fault> {
        let map = map.into();
        let global_planner = self.new_global_planner(map.obstacles.frame().resolution_m)?;
        let planner = LocalPlanner::new(engine, self.local.clone());
        let (robot, settings) = (self.robot.model(), self.navigator.clone());
        let navigator =
            Navigator::new(map, waypoints, robot, planner, global_planner, settings, clock)?;
        Ok(match controller {
            Some(controller) => navigator.with_controller(controller),
            None => navigator,
        })
    }

    /// Starts the controller of the settings; none for inbye's own behaviours. To the controller closed zones are obstacles.
    ///
    /// # Errors
    /// When the program cannot be started.
    pub fn new_controller(
        &self,
        map: &NavigationMap,
    ) -> Result<Option<Box<dyn Controller>>, Fault> {
        if !self.controller.is_set() {
            return Ok(None);
        }
        let (robot, period_s) = (self.robot.model(), self.local.control_period_s);
        let (program, navigator) = (&self.controller, &self.navigator);
        let controller =
            ProcessController::start(program, &robot, period_s, navigator, &map.closed())?;
        Ok(Some(Box::new(controller)))
    }

    /// Prepares a map for [`Navigator::replace_map`]. It takes time in proportion to the map's area.
    ///
    /// # Errors
    /// When the program of the settings that plans, or the planning thread, does not start.
    pub fn prepare_map(&self, map: impl Into<NavigationMap>) -> Result<PreparedMap, Fault> {
        let map = map.into();
        let global_planner = self.new_global_planner(map.obstacles.frame().resolution_m)?;
        PreparedMap::new(map, global_planner, &self.navigator)
    }

    /// Replaces the goals of a navigator with these settings, as [`Navigator::replace_goals`].
    ///
    /// # Errors
    /// As [`Navigator::replace_goals`], and when the program of the settings that plans does not start or end.
    pub fn replace_goals(
        &self,
        navigator: &mut Navigator,
        waypoints: &Waypoints,
        clock: &mut dyn FnMut() -> f64,
    ) -> Result<(), Fault> {
        let resolution_m = navigator.obstacle_model().closed().frame().resolution_m;
        self.with_global_planner(resolution_m, |planner| {
            navigator.replace_goals(waypoints, planner, clock)
        })
    }

    /// Plans paths to goals on a map, for [`Navigator::follow_goals`]. It takes time in proportion to the map's area.
    ///
    /// # Errors
    /// As [`PlannedGoals::new`], and when the program of the settings that plans does not start or end.
    pub fn plan_goals(
        &self,
        map: impl Into<NavigationMap>,
        waypoints: &Waypoints,
        clock: &mut dyn FnMut() -> f64,
    ) -> Result<PlannedGoals, Fault> {
        let map = map.into();
        let model = (&self.robot.model(), &self.navigator);
        self.with_global_planner(map.obstacles.frame().resolution_m, |planner| {
            PlannedGoals::new(map, waypoints, model, planner, clock)
        })
    }

    /// Plans with a global planner of its own, which ends afterwards.
    fn with_global_planner<T>(
        &self,
        resolution_m: f64,
        plan: impl FnOnce(&mut dyn GlobalPlanner) -> Result<T, Fault>,
    ) -> Result<T, Fault> {
        let mut planner = self.new_global_planner(resolution_m)?;
        let planned = plan(&mut *planner)?;
        planner.finish().map_err(Fault::Plan)?;
        Ok(planned)
    }

    /// Creates the global planner of the settings, on maps of a resolution in metres.
    ///
    /// # Errors
    /// When its program cannot be started.
    pub fn new_global_planner(&self, resolution_m: f64) -> Result<Box<dyn GlobalPlanner>, Fault> {
        let own = self.route_planner(resolution_m);
        Ok(match self.start_global_planner(own.least_radius_m())? {
            Some(program) => Box::new(program),
            None => Box::new(own),
        })
    }

    /// Starts the program of the settings that plans global paths at this distance from obstacles, metres; none where no program
    /// is set.
    ///
    /// # Errors
    /// When it cannot be started.
    pub fn start_global_planner(
        &self,
        radius_m: f64,
    ) -> Result<Option<ProcessPlanner>, global::PlanError> {
        if !self.global_planner.is_set() {
            return Ok(None);
        }
        let (robot, period_s) = (self.robot.model(), self.local.control_period_s);
        ProcessPlanner::start(&self.global_planner, &robot, period_s, radius_m).map(Some)
    }
}
