//! The settings that follow from parameters, and the reasons of unmapped parameters.

use inbye::base::BaseConfig;
use inbye::robot::{Footprint, Polygon};
use inbye::ros::nav2::{Import, UnmappedReason, import};
use inbye::runtime::Config;

use serde_json::json;

use super::files::{DWB, ROBOTS, SHIM};

fn import_valid(text: &str, namespace: Option<&str>) -> (Import, Config, BaseConfig) {
    let imported = import(text, namespace).expect("a valid file");
    let config: Config = toml::from_str(&imported.config).expect("valid settings");
    let base: BaseConfig = toml::from_str(&imported.base_config).expect("valid settings");
    assert_eq!(config.validate(), Ok(()));
    assert_eq!(base.validate(), Ok(()));
    (imported, config, base)
}

fn unmapped<'a>(imported: &'a Import, parameter: &str) -> (UnmappedReason, &'a str) {
    let mut all = imported.unmapped.iter();
    let found = all.find(|unmapped| unmapped.parameter == parameter);
    let found = found.unwrap_or_else(|| panic!("{parameter} is not listed"));
    (found.reason, &found.explanation)
}

#[test]
fn tighter_limit_of_dwb_and_smoother_applies() {
    let (imported, config, base) = import_valid(DWB, None);
    let limits = config.robot.limits;
    // DWB's limit in any direction is below its limit along x, and the smoother's limit is above both.
    assert_eq!((limits.min_vel_x, limits.max_vel_x), (-0.1, 0.4));
    // The smoother's limit to the right is lower than to the left.
    assert_eq!(limits.max_vel_theta, 0.9);
    assert_eq!((limits.acc_lim_x, limits.acc_lim_theta), (1.5, 3.2));
    assert_eq!((limits.decel_lim_x, limits.decel_lim_theta), (-2.5, -3.0));
    let local = &config.local;
    assert_eq!((local.vx_samples, local.vtheta_samples), (20, 30));
    assert_eq!((local.control_period_s, local.sim_time_s), (0.05, 1.7));
    let navigator = &config.navigator;
    assert_eq!(navigator.required_movement_radius, 0.4);
    // The first checker of the list is not the first in the file; its yaw tolerance is above pi.
    assert_eq!(navigator.xy_goal_tolerance, 0.15);
    assert_eq!(navigator.yaw_goal_tolerance, core::f64::consts::PI);
    assert_eq!((base.supervisor.rate_hz, base.supervisor.target_timeout_s), (30.0, 0.8));
    assert_eq!(base.base.tracks.deadband, 0.03);

    let is_not_in_effect = |key| unmapped(&imported, key).0 == UnmappedReason::NotInEffect;
    for key in [
        "controller_server.rough.xy_goal_tolerance",
        "controller_server.Slow.max_vel_x",
        "local_costmap.local_costmap.robot_radius",
    ] {
        assert!(is_not_in_effect(key), "{key}");
    }
    let (reason, explanation) = unmapped(&imported, "controller_server.FollowPath.max_vel_thta");
    assert_eq!(reason, UnmappedReason::Unknown);
    assert!(explanation.contains("`max_vel_theta`"), "{explanation}");
    for (key, reason) in [
        ("FollowPath.PathDist.scale", UnmappedReason::DifferentMeaning),
        ("FollowPath.BaseObstacle.scale", UnmappedReason::DifferentMeaning),
        ("FollowPath.RotateToGoal.slowing_factor", UnmappedReason::NoEquivalent),
        ("FollowPath.vy_samples", UnmappedReason::NoEquivalent),
        ("progress_checker.movement_time_allowance", UnmappedReason::DifferentMeaning),
        ("failure_tolerance", UnmappedReason::DifferentMeaning),
        ("use_sim_time", UnmappedReason::NoEquivalent),
    ] {
        let key = format!("controller_server.{key}");
        assert_eq!(unmapped(&imported, &key).0, reason, "{key}");
    }
    assert_eq!(imported.ignored_nodes, ["amcl"]);
}

#[test]
fn discs_cover_padded_footprint() {
    let (_, config, _) = import_valid(DWB, None);
    let discs = config.robot.footprint.discs();
    let body = config.robot.footprint.body().expect("a polygon");
    assert_eq!(body, &Polygon::rectangle(0.74, 0.54).expect("a rectangle"));
    for (x, y) in [(0.37, 0.27), (-0.37, 0.27), (0.37, -0.27), (0.0, 0.27)] {
        let covers =
            |disc: &inbye::robot::Disc| libm::hypot(x - disc.x, y - disc.y) <= disc.radius + 1e-12;
        assert!(discs.iter().any(covers), "({x}, {y}) in {discs:?}");
    }
    let round = DWB.replace(
        "footprint: \"[ [0.35, 0.25], [0.35, -0.25], [-0.35, -0.25], [-0.35, 0.25] ]\"",
        "footprint: \"[]\"",
    );
    let (imported, config, _) = import_valid(&round, None);
    assert_eq!(config.robot.footprint, Footprint::round(0.24).expect("above zero"));
    let empty = unmapped(&imported, "local_costmap.local_costmap.footprint");
    assert_eq!(empty.0, UnmappedReason::NotInEffect);
}

#[test]
fn mppi_in_shim_gives_limits_horizon_and_thresholds() {
    let (imported, config, _) = import_valid(SHIM, None);
    let limits = config.robot.limits;
    assert_eq!((limits.min_vel_x, limits.max_vel_x, limits.max_vel_theta), (-0.35, 0.5, 1.9));
    assert_eq!((limits.acc_lim_x, limits.decel_lim_x), (3.0, -2.0));
    assert_eq!((limits.acc_lim_theta, limits.decel_lim_theta), (3.5, -3.5));
    let local = &config.local;
    assert_eq!((local.sim_step_s, local.sim_time_s, local.steps()), (0.05, 2.8, 56));
    assert_eq!((local.vx_samples, local.vtheta_samples), (31, 64));
    assert_eq!(local.control_period_s, 0.04);
    let navigator = &config.navigator;
    assert_eq!(navigator.scan_timeout_s, 0.4);
    // The default of the lower threshold would exceed the upper one: half of it, Nav2's default, applies.
    assert_eq!((navigator.rotate_in_place_from, navigator.rotate_in_place_until), (0.2, 0.1));
    let (reason, explanation) = unmapped(&imported, "controller_server.Other.desired_linear_vel");
    assert_eq!(reason, UnmappedReason::NotSupported);
    assert!(explanation.contains("RegulatedPurePursuit"), "{explanation}");
    assert_eq!(
        unmapped(&imported, "controller_server.FollowPath.GoalCritic.cost_weight").0,
        UnmappedReason::DifferentMeaning
    );
    assert!(imported.base_config.is_empty());
}

/// Older and newer names of the highest speed, with and without a shim, and Nav2's default.
#[test]
fn pure_pursuit_gives_its_highest_speeds() {
    let plugin = "nav2_regulated_pure_pursuit_controller::RegulatedPurePursuitController";
    let shim = "nav2_rotation_shim_controller::RotationShimController";
    let own = format!("plugin: {plugin}");
    let shimmed = format!("plugin: {shim}\n      primary_controller: {plugin}");
    for (controller, given, speed) in [
        (&own, "desired_linear_vel: 0.3", 0.3),
        (&own, "max_linear_vel: 0.7", 0.7),
        (&own, "desired_linear_vel: 0.6\n      max_linear_vel: 0.4", 0.4),
        (&own, "max_angular_vel: 0.9", 0.5),
        (&shimmed, "desired_linear_vel: 0.3", 0.3),
    ] {
        let text = format!(
            "controller_server:\n  ros__parameters:\n    controller_plugins: [FollowPath]\n    FollowPath:\n      {controller}\n      \
             {given}\n      lookahead_time: 1.5\n"
        );
        let (imported, config, _) = import_valid(&text, None);
        assert_eq!(config.robot.limits.max_vel_x, speed, "{text}");
        let (reason, _) = unmapped(&imported, "controller_server.FollowPath.lookahead_time");
        assert_eq!(reason, UnmappedReason::NotSupported, "{text}");
    }
}

/// Newer files nest the controller in the shim.
#[test]
fn controller_nested_in_shim_is_imported() {
    let nested = r#"
controller_server:
  ros__parameters:
    FollowPath:
      plugin: "nav2_rotation_shim_controller::RotationShimController"
      angular_dist_threshold: 0.8
      angular_disengage_threshold: 0.4
      primary_controller:
        plugin: "dwb_core::DWBLocalPlanner"
        max_vel_x: 0.7
        discretize_by_time: true
        time_granularity: 0.2
"#;
    let (imported, config, _) = import_valid(nested, None);
    assert_eq!(config.robot.limits.max_vel_x, 0.7);
    assert_eq!(config.local.sim_step_s, 0.2);
    assert_eq!(config.navigator.rotate_in_place_from, 0.8);
    assert_eq!(config.navigator.rotate_in_place_until, 0.4);
    assert_eq!(imported.mapped.len(), 4);
}

#[test]
fn missing_part_of_horizon_has_nav2_default() {
    let only = |line: &str| {
        format!(
            "controller_server:\n  ros__parameters:\n    FollowPath:\n      plugin: nav2_mppi_controller::MPPIController\n      {line}\n"
        )
    };
    let (_, config, _) = import_valid(&only("time_steps: 30"), None);
    assert_eq!((config.local.sim_step_s, config.local.sim_time_s), (0.05, 1.5));
    let (imported, config, _) = import_valid(&only("model_dt: 0.1"), None);
    assert_eq!((config.local.sim_step_s, config.local.sim_time_s), (0.1, 5.6));
    assert!(imported.config.contains("56 x 0.1"), "{}", imported.config);
}

/// Where Nav2's default of a missing parameter is safer than ours: no reverse, a slower robot, a wider footprint.
#[test]
fn missing_limits_have_nav2_defaults() {
    let controller = |lines: &str| {
        format!("controller_server:\n  ros__parameters:\n    FollowPath:\n      {lines}\n")
    };
    let dwb = controller("plugin: dwb_core::DWBLocalPlanner\n      max_vel_x: 0.4");
    let (imported, config, _) = import_valid(&dwb, None);
    assert_eq!((config.robot.limits.min_vel_x, config.robot.limits.max_vel_x), (0.0, 0.4));
    let path = "controller_server.FollowPath.min_vel_x";
    let comment = format!("# From {path} (not given: Nav2's default).\nmin_vel_x = 0.0\n");
    assert!(imported.config.contains(&comment), "{}", imported.config);
    assert_eq!(imported.defaults.len(), 1);
    assert_eq!(imported.defaults[0].parameter, path);
    assert!(imported.mapped.iter().all(|mapped| mapped.parameter != path));
    // The tighter limit applies, as for given parameters.
    let smoother = "velocity_smoother:\n  ros__parameters:\n    min_velocity: [-0.2, 0.0, -1.0]\n";
    let (_, config, _) = import_valid(&(dwb + smoother), None);
    assert_eq!(config.robot.limits.min_vel_x, 0.0);
    let mppi = controller("plugin: nav2_mppi_controller::MPPIController\n      time_steps: 20");
    assert_eq!(import_valid(&mppi, None).1.robot.limits.max_vel_x, 0.5);
    let costmap = |lines: &str| {
        format!("local_costmap:\n  local_costmap:\n    ros__parameters:\n      {lines}\n")
    };
    let (imported, config, _) = import_valid(&costmap("robot_radius: 0.3"), None);
    assert_eq!(config.robot.footprint, Footprint::round(0.31).expect("above zero"));
    assert_eq!(imported.defaults[0].parameter, "local_costmap.local_costmap.footprint_padding");
    let given = costmap("robot_radius: 0.3\n      footprint_padding: 0.0");
    assert_eq!(
        import_valid(&given, None).1.robot.footprint,
        Footprint::round(0.3).expect("above zero")
    );
}

/// Nav2 loads only the plugins in its lists: the limits of others do not apply.
#[test]
fn plugins_that_are_not_listed_are_not_in_effect() {
    let text = r#"
controller_server:
  ros__parameters:
    controller_plugins: ["FollowPath"]
    goal_checker_plugins: ["goal"]
    progress_checker_plugins: []
    Docking: {plugin: "dwb_core::DWBLocalPlanner", max_vel_x: 2.0}
    FollowPath: {plugin: "nav2_graceful_controller::GracefulController", v_linear_max: 0.3}
    rough: {plugin: "nav2_controller::SimpleGoalChecker", xy_goal_tolerance: 0.5}
    goal: {plugin: "nav2_controller::SimpleGoalChecker", xy_goal_tolerance: 0.15}
    progress: {plugin: "nav2_controller::SimpleProgressChecker", required_movement_radius: 0.9}
"#;
    let (imported, config, _) = import_valid(text, None);
    let default = Config::default();
    assert_eq!(config.robot.limits, default.robot.limits);
    assert_eq!(config.navigator.xy_goal_tolerance, 0.15);
    assert_eq!(
        config.navigator.required_movement_radius,
        default.navigator.required_movement_radius
    );
    for (parameter, list) in [
        ("Docking.max_vel_x", "controller_plugins"),
        ("rough.xy_goal_tolerance", "goal_checker_plugins"),
        ("progress.required_movement_radius", "progress_checker_plugins"),
    ] {
        let path = format!("controller_server.{parameter}");
        let (reason, explanation) = unmapped(&imported, &path);
        assert_eq!(reason, UnmappedReason::NotInEffect);
        assert!(explanation.starts_with(&format!("{list} does not name it")), "{explanation}");
    }
    let (reason, _) = unmapped(&imported, "controller_server.FollowPath.v_linear_max");
    assert_eq!(reason, UnmappedReason::NotSupported);
}

#[test]
fn costmap_filters_are_referred_to_the_flags_of_their_masks() {
    let filters = r#"
      filters: ["no_go", "speed"]
      no_go: {plugin: "nav2_costmap_2d::KeepoutFilter", filter_info_topic: "/keepout_info"}
      speed: {plugin: "nav2_costmap_2d::SpeedFilter", speed_limit_topic: "/speed_limit"}
"#;
    let text: String = ["local_costmap", "global_costmap"]
        .map(|name| {
            let radius = "      robot_radius: 0.3";
            format!("{name}:\n  {name}:\n    ros__parameters:\n{radius}{filters}")
        })
        .concat();
    let (imported, ..) = import_valid(&text, None);
    for (parameter, flag) in [
        ("local_costmap.local_costmap.no_go.filter_info_topic", "--keepout"),
        ("local_costmap.local_costmap.filters", "--keepout"),
        ("global_costmap.global_costmap.no_go.plugin", "--keepout"),
        ("local_costmap.local_costmap.speed.plugin", "--speed-zones"),
        ("global_costmap.global_costmap.speed.speed_limit_topic", "--speed-zones"),
    ] {
        let (_, explanation) = unmapped(&imported, parameter);
        assert!(explanation.contains(flag), "{parameter}: {explanation}");
    }
    assert_eq!(imported.ignored_nodes, ["global_costmap.global_costmap"]);
}

#[test]
fn robot_has_own_and_common_parameters() {
    let (one, config, _) = import_valid(ROBOTS, Some("robot1"));
    assert_eq!(config.robot.limits.max_vel_x, 0.3);
    assert_eq!(config.local.control_period_s, 0.1);
    assert_eq!(config.robot.footprint, Footprint::round(0.31).expect("above zero"));
    // Its own rate overrides the common one.
    assert_eq!(unmapped(&one, "/**.controller_frequency").0, UnmappedReason::NotInEffect);
    assert_eq!(one.ignored_nodes, ["/robot2/controller_server"]);
    let (two, config, _) = import_valid(ROBOTS, Some("/robot2"));
    assert_eq!(config.robot.limits.max_vel_x, 0.6);
    assert_eq!(config.local.control_period_s, 0.2);
    assert!(two.ignored_nodes.contains(&"robot1.controller_server".to_owned()));
}

#[test]
fn config_has_exactly_the_mapped_settings() {
    for (text, namespace) in [(DWB, None), (SHIM, None), (ROBOTS, Some("robot2"))] {
        let imported = import(text, namespace).expect("a valid file");
        let both: toml::Table =
            (imported.config.clone() + &imported.base_config).parse().expect("different tables");
        let all = || imported.mapped.iter().chain(&imported.defaults);
        let mut keys: Vec<&str> =
            all().flat_map(|mapped| &mapped.settings).map(|setting| setting.setting).collect();
        keys.sort_unstable();
        keys.dedup();
        let lines = (imported.config.lines().chain(imported.base_config.lines()))
            .filter(|line| line.contains(" = ") && !line.starts_with('#'));
        assert_eq!(lines.count(), keys.len());
        for key in keys {
            let mut value = &toml::Value::Table(both.clone());
            for name in key.split('.') {
                value = &value[name];
            }
            let of = all().flat_map(|mapped| &mapped.settings);
            assert!(
                of.filter(|setting| setting.setting == key)
                    .all(|setting| setting.value == json!(value)),
                "{key}"
            );
        }
    }
}

#[test]
fn frequency_of_the_controller_is_one_that_the_node_can_keep() {
    for (hertz, period_s) in [("3.0", 0.25), ("50.0", 0.02), ("1000.0", 0.01)] {
        let text =
            DWB.replace("controller_frequency: 20.0", &["controller_frequency: ", hertz].concat());
        let (_, config, _) = import_valid(&text, None);
        assert_eq!(config.local.control_period_s, period_s, "{hertz}");
    }
}

#[test]
fn collision_monitor_is_referred_to_its_table() {
    let monitor = "collision_monitor:\n  ros__parameters:\n    polygons: [\"PolygonStop\"]\n    PolygonStop:\n      type: polygon\n";
    let imported = import(&[DWB, "\n", monitor].concat(), None).expect("a valid file");
    for parameter in ["polygons", "PolygonStop.type"] {
        let (reason, explanation) =
            unmapped(&imported, &["collision_monitor.", parameter].concat());
        assert_eq!(reason, UnmappedReason::NotSupported);
        assert!(explanation.contains("collision_monitor.polygons"), "{explanation}");
    }
    assert_eq!(imported.ignored_nodes, ["amcl"]);
}

/// The rest of the file is imported.
#[test]
fn base_value_out_of_range_is_listed_and_left_out() {
    let text = DWB
        .replace("smoothing_frequency: 30.0", "smoothing_frequency: 2.0")
        .replace("deadband_velocity: [0.03", "deadband_velocity: [3.0");
    let (imported, config, base) = import_valid(&text, None);
    for (parameter, words) in
        [("smoothing_frequency", "rate_hz is 2"), ("deadband_velocity", "deadband is 3")]
    {
        let path = format!("velocity_smoother.{parameter}");
        let (reason, explanation) = unmapped(&imported, &path);
        assert_eq!(reason, UnmappedReason::OutOfRange);
        assert!(explanation.contains(words), "{explanation}");
        assert!(imported.mapped.iter().all(|mapped| mapped.parameter != path));
    }
    let default = BaseConfig::default().supervisor.rate_hz;
    assert_eq!((base.supervisor.rate_hz, base.supervisor.target_timeout_s), (default, 0.8));
    assert_eq!(config.robot.limits.max_vel_x, 0.4);
}

/// Nav2's default of `allow_reversing` is false.
#[test]
fn pure_pursuit_reverses_only_where_it_is_allowed() {
    for (line, is_forbidden) in
        [("", true), ("allow_reversing: false", true), ("allow_reversing: true", false)]
    {
        let text = format!(
            "controller_server:\n  ros__parameters:\n    FollowPath:\n      \
             plugin: nav2_regulated_pure_pursuit_controller::RegulatedPurePursuitController\n      \
             desired_linear_vel: 0.4\n      {line}\n"
        );
        let (imported, ..) = import_valid(&text, None);
        assert_eq!(imported.config.contains("min_vel_x = 0.0"), is_forbidden, "{line}");
    }
}

#[test]
fn footprint_of_the_global_costmap_counts_where_the_local_one_has_none() {
    let costmap = |name: &str, line: &str| {
        format!("{name}:\n  {name}:\n    ros__parameters:\n      width: 3\n      {line}\n")
    };
    let global = costmap("global_costmap", "robot_radius: 0.4");
    let (imported, config, _) = import_valid(&(costmap("local_costmap", "") + &global), None);
    assert_eq!(config.robot.footprint, Footprint::round(0.4 + 0.01).expect("above zero"));
    let source = "# From global_costmap.global_costmap.robot_radius (one disc).";
    assert!(imported.config.contains(source), "{}", imported.config);
    assert!(imported.ignored_nodes.is_empty(), "{:?}", imported.ignored_nodes);
    let both = costmap("local_costmap", "robot_radius: 0.3") + &global;
    let (imported, config, _) = import_valid(&both, None);
    assert_eq!(config.robot.footprint, Footprint::round(0.31).expect("above zero"));
    assert!(!imported.config.contains("Warning"), "{}", imported.config);
    assert!(imported.warnings.is_empty(), "{:?}", imported.warnings);
    let none = "controller_server:\n  ros__parameters: {controller_frequency: 10.0}\n";
    let (imported, config, _) = import_valid(none, None);
    assert_eq!(config.robot.footprint, Config::default().robot.footprint);
    assert!(imported.config.starts_with("# Warning: no costmap has a footprint"));
    assert!(imported.warnings[0].starts_with("no costmap has a footprint"));
}

#[test]
fn few_samples_are_a_warning() {
    for (plugin, lines, samples) in [
        ("nav2_mppi_controller::MPPIController", "batch_size: 1", Some("1 x 1 samples")),
        ("nav2_mppi_controller::MPPIController", "batch_size: 49", Some("4 x 12 samples")),
        ("nav2_mppi_controller::MPPIController", "batch_size: 50", None),
        ("dwb_core::DWBLocalPlanner", "vx_samples: 1", Some("1 x 40 samples")),
        ("dwb_core::DWBLocalPlanner", "vx_samples: 2", None),
    ] {
        let text = format!(
            "controller_server:\n  ros__parameters:\n    FollowPath:\n      plugin: {plugin}\n      {lines}\n"
        );
        let (imported, ..) = import_valid(&text, None);
        let parameter = lines.split(':').next().expect("a name");
        let start = format!("controller_server.FollowPath.{parameter}");
        let found = imported.warnings.iter().find(|warning| warning.starts_with(&start));
        assert_eq!(found.is_some(), samples.is_some(), "{lines}: {:?}", imported.warnings);
        assert!(samples.is_none_or(|samples| found.is_some_and(|found| found.contains(samples))));
    }
}

#[test]
fn max_points_of_an_older_collision_monitor_is_explained() {
    let monitor =
        "collision_monitor:\n  ros__parameters:\n    PolygonStop: {max_points: 3, type: polygon}\n";
    let imported = import(&[DWB, monitor].concat(), None).expect("a valid file");
    for (parameter, is_explained) in [("max_points", true), ("type", false)] {
        let found = unmapped(&imported, &format!("collision_monitor.PolygonStop.{parameter}"));
        assert_eq!(found.1.contains("`min_points = N + 1`"), is_explained, "{}", found.1);
    }
}

#[test]
fn motion_model_without_rotation_on_the_spot_is_a_warning() {
    for (model, reason) in [
        ("DiffDrive", UnmappedReason::NoEquivalent),
        ("Ackermann", UnmappedReason::NotSupported),
        ("Omni", UnmappedReason::NotSupported),
    ] {
        let text = SHIM.replace("motion_model: \"DiffDrive\"", &format!("motion_model: {model}"));
        let imported = import(&text, None).expect("a valid file");
        let found = unmapped(&imported, "controller_server.FollowPath.motion_model");
        assert_eq!(found.0, reason, "{model}: {}", found.1);
        let warning =
            format!("controller_server.FollowPath.motion_model: {model} is not supported");
        let has_warning = imported.warnings.iter().any(|found| found.starts_with(&warning));
        assert_eq!(has_warning, model != "DiffDrive", "{:?}", imported.warnings);
        assert_eq!(imported.config.contains(&format!("# Warning: {warning}")), has_warning);
    }
}

#[test]
fn topics_of_the_node_are_named() {
    let line = "controller_frequency: 20.0";
    let topics = "odom_topic: odometry\n    speed_limit_topic: limit";
    let text = DWB.replace(line, &format!("{line}\n    {topics}"));
    let (imported, ..) = import_valid(&text, None);
    for (parameter, topic) in [("odom_topic", "`odom`"), ("speed_limit_topic", "`speed_limit`")] {
        let (_, explanation) = unmapped(&imported, &format!("controller_server.{parameter}"));
        assert!(explanation.contains(topic), "{explanation}");
    }
}
