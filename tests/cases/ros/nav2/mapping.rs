//! What the settings become, and why others do not.

use inbye::base::BaseConfig;
use inbye::robot::Footprint;
use inbye::ros::nav2::{Import, Why, import};
use inbye::runtime::Config;

use super::files::{DWB, ROBOTS, SHIM};

fn taken(text: &str, namespace: Option<&str>) -> (Import, Config, BaseConfig) {
    let taken = import(text, namespace).expect("a file that can be taken over");
    let config: Config = toml::from_str(&taken.config).expect("settings of ours");
    let base: BaseConfig = toml::from_str(&taken.base_config).expect("settings of a base");
    assert_eq!(config.validate(), Ok(()));
    assert_eq!(base.validate(), Ok(()));
    (taken, config, base)
}

fn left<'a>(taken: &'a Import, key: &str) -> (Why, &'a str) {
    let found = taken.not_mapped.iter().find(|left| left.key == key);
    let found = found.unwrap_or_else(|| panic!("{key} is not listed"));
    (found.why, &found.reason)
}

#[test]
fn dwb_and_the_smoother_give_the_tighter_limits() {
    let (taken, config, base) = taken(DWB, None);
    let limits = config.robot.limits;
    // DWB's highest speed in any direction is below that along x, and the smoother's is above both.
    assert_eq!((limits.min_vel_x, limits.max_vel_x), (-0.1, 0.4));
    // The smoother turns right more slowly than left.
    assert_eq!(limits.max_vel_theta, 0.9);
    assert_eq!((limits.acc_lim_x, limits.acc_lim_theta), (1.5, 3.2));
    assert_eq!((limits.decel_lim_x, limits.decel_lim_theta), (-2.5, -3.0));
    let local = &config.local;
    assert_eq!((local.vx_samples, local.vtheta_samples), (20, 30));
    assert_eq!((local.control_period_s, local.sim_time_s), (0.05, 1.7));
    let navigator = &config.navigator;
    assert_eq!(navigator.required_movement_radius, 0.4);
    // The first of the list, though it is not the first in the file; and any yaw.
    assert_eq!(navigator.xy_goal_tolerance, 0.15);
    assert_eq!(navigator.yaw_goal_tolerance, core::f64::consts::PI);
    assert_eq!(
        (base.supervisor.rate_hz, base.supervisor.target_timeout_s),
        (30.0, 0.8)
    );
    assert_eq!(base.base.tracks.deadband, 0.03);

    let in_force = |key| left(&taken, key).0 == Why::NotInForce;
    for key in [
        "controller_server.rough.xy_goal_tolerance",
        "controller_server.Slow.max_vel_x",
        "local_costmap.local_costmap.robot_radius",
    ] {
        assert!(in_force(key), "{key}");
    }
    let (why, reason) = left(&taken, "controller_server.FollowPath.max_vel_thta");
    assert_eq!(why, Why::Unknown);
    assert!(reason.contains("`max_vel_theta`"), "{reason}");
    for (key, why) in [
        ("FollowPath.PathDist.scale", Why::OtherMeaning),
        ("FollowPath.BaseObstacle.scale", Why::OtherMeaning),
        ("FollowPath.RotateToGoal.slowing_factor", Why::NoSuchThing),
        ("FollowPath.vy_samples", Why::NoSuchThing),
        (
            "progress_checker.movement_time_allowance",
            Why::OtherMeaning,
        ),
        ("failure_tolerance", Why::OtherMeaning),
        ("use_sim_time", Why::NoSuchThing),
    ] {
        let key = format!("controller_server.{key}");
        assert_eq!(left(&taken, &key).0, why, "{key}");
    }
    assert_eq!(taken.ignored, ["amcl"]);
}

/// The discs hold the corners of the footprint and its padding.
#[test]
fn a_footprint_is_covered_and_padded() {
    let (_, config, _) = taken(DWB, None);
    let discs = config.robot.footprint.discs();
    for (x, y) in [(0.35, 0.25), (-0.35, 0.25), (0.35, -0.25), (0.0, 0.25)] {
        let held = |disc: &inbye::robot::Disc| {
            libm::hypot(x - disc.x, y - disc.y) <= disc.radius - 0.02 + 1e-12
        };
        assert!(discs.iter().any(held), "({x}, {y}) in {discs:?}");
    }
    let round = DWB.replace(
        "footprint: \"[ [0.35, 0.25], [0.35, -0.25], [-0.35, -0.25], [-0.35, 0.25] ]\"",
        "footprint: \"[]\"",
    );
    let (taken, config, _) = taken(&round, None);
    assert_eq!(
        config.robot.footprint,
        Footprint::round(0.24).expect("above zero")
    );
    let empty = left(&taken, "local_costmap.local_costmap.footprint");
    assert_eq!(empty.0, Why::NotInForce);
}

#[test]
fn mppi_in_a_shim_gives_limits_horizon_and_turning_in_place() {
    let (taken, config, _) = taken(SHIM, None);
    let limits = config.robot.limits;
    assert_eq!(
        (limits.min_vel_x, limits.max_vel_x, limits.max_vel_theta),
        (-0.35, 0.5, 1.9)
    );
    assert_eq!((limits.acc_lim_x, limits.decel_lim_x), (3.0, -2.0));
    assert_eq!((limits.acc_lim_theta, limits.decel_lim_theta), (3.5, -3.5));
    let local = &config.local;
    assert_eq!(
        (local.sim_step_s, local.sim_time_s, local.steps()),
        (0.05, 2.8, 56)
    );
    assert_eq!((local.vx_samples, local.vtheta_samples), (31, 64));
    assert_eq!(local.control_period_s, 0.04);
    let navigator = &config.navigator;
    assert_eq!(navigator.scan_timeout_s, 0.4);
    // Ours would end above where it begins: half, as Nav2 has it.
    assert_eq!(
        (
            navigator.rotate_in_place_from,
            navigator.rotate_in_place_until
        ),
        (0.2, 0.1)
    );
    let (why, reason) = left(&taken, "controller_server.Other.desired_linear_vel");
    assert_eq!(why, Why::NotYet);
    assert!(reason.contains("RegulatedPurePursuit"), "{reason}");
    assert_eq!(
        left(
            &taken,
            "controller_server.FollowPath.GoalCritic.cost_weight"
        )
        .0,
        Why::OtherMeaning
    );
    assert!(taken.base_config.is_empty());
}

/// Newer files may nest the controller that is within the shim.
#[test]
fn a_controller_nested_in_a_shim_is_the_same() {
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
    let (taken, config, _) = taken(nested, None);
    assert_eq!(config.robot.limits.max_vel_x, 0.7);
    assert_eq!(config.local.sim_step_s, 0.2);
    assert_eq!(config.navigator.rotate_in_place_from, 0.8);
    assert_eq!(config.navigator.rotate_in_place_until, 0.4);
    assert_eq!(taken.mapped.len(), 4);
}

/// With less of the horizon given, the rest of it is Nav2's default, and is said to be.
#[test]
fn half_a_horizon_is_made_whole_by_nav2s_defaults() {
    let only = |line: &str| {
        format!(
            "controller_server:\n  ros__parameters:\n    FollowPath:\n      plugin: nav2_mppi_controller::MPPIController\n      {line}\n"
        )
    };
    let (_, config, _) = taken(&only("time_steps: 30"), None);
    assert_eq!(
        (config.local.sim_step_s, config.local.sim_time_s),
        (0.05, 1.5)
    );
    let (taken, config, _) = taken(&only("model_dt: 0.1"), None);
    assert_eq!(
        (config.local.sim_step_s, config.local.sim_time_s),
        (0.1, 5.6)
    );
    assert!(taken.config.contains("56 x 0.1"), "{}", taken.config);
}

#[test]
fn each_robot_has_its_own_and_what_holds_for_all() {
    let (one, config, _) = taken(ROBOTS, Some("robot1"));
    assert_eq!(config.robot.limits.max_vel_x, 0.3);
    assert_eq!(config.local.control_period_s, 0.1);
    assert_eq!(
        config.robot.footprint,
        Footprint::round(0.3).expect("above zero")
    );
    // Its own rate takes the place of that for all.
    assert_eq!(left(&one, "/**.controller_frequency").0, Why::NotInForce);
    assert_eq!(one.ignored, ["/robot2/controller_server"]);
    let (two, config, _) = taken(ROBOTS, Some("/robot2"));
    assert_eq!(config.robot.limits.max_vel_x, 0.6);
    assert_eq!(config.local.control_period_s, 0.2);
    assert!(two.ignored.contains(&"robot1.controller_server".to_owned()));
}

/// What the file does not give stays as it is, and every line of the text is one that the lists have.
#[test]
fn the_text_holds_what_is_mapped_and_nothing_else() {
    for (text, namespace) in [(DWB, None), (SHIM, None), (ROBOTS, Some("robot2"))] {
        let taken = import(text, namespace).expect("a file that can be taken over");
        let both: toml::Table = (taken.config.clone() + &taken.base_config)
            .parse()
            .expect("the tables differ");
        let mut keys: Vec<&str> = taken
            .mapped
            .iter()
            .flat_map(|mapped| &mapped.to)
            .map(|to| to.key)
            .collect();
        keys.sort_unstable();
        keys.dedup();
        let lines = (taken.config.lines().chain(taken.base_config.lines()))
            .filter(|line| line.contains(" = ") && !line.starts_with('#'));
        assert_eq!(lines.count(), keys.len());
        for key in keys {
            let mut value = &toml::Value::Table(both.clone());
            for name in key.split('.') {
                value = &value[name];
            }
            let of = taken.mapped.iter().flat_map(|mapped| &mapped.to);
            assert!(
                of.filter(|to| to.key == key).all(|to| to.value == *value),
                "{key}"
            );
        }
    }
}
