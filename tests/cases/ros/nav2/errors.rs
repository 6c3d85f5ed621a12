//! Files that cannot be imported, and their error messages.

use inbye::ros::nav2::import;

use super::files::{DWB, ROBOTS};

#[track_caller]
fn assert_rejected(text: &str, namespace: Option<&str>, words: &str) {
    let error = import(text, namespace).expect_err(words);
    let message = error.to_string();
    assert_eq!(message.lines().count(), 1, "{message}");
    for word in words.split("; ") {
        assert!(message.contains(word), "no {word:?} in: {message}");
    }
}

#[test]
fn invalid_values_are_rejected_with_their_path() {
    for (from, to, words) in [
        ("max_vel_x: 0.45", "max_vel_x: fast", "FollowPath.max_vel_x is \"fast\"; a finite number"),
        ("max_vel_x: 0.45", "max_vel_x: .nan", "FollowPath.max_vel_x; a finite number"),
        ("max_vel_x: 0.45", "max_vel_x:", "FollowPath.max_vel_x is null"),
        ("vx_samples: 20", "vx_samples: 0", "FollowPath.vx_samples is 0; a whole number, 1 to"),
        ("vx_samples: 20", "vx_samples: 2.5", "FollowPath.vx_samples is 2.5"),
        ("vx_samples: 20", "vx_samples: 4000000", "vx_samples; vtheta_samples; 1 to 4194304"),
        (
            "controller_frequency: 20.0",
            "controller_frequency: 0.0",
            "controller_frequency is 0.0; above zero",
        ),
        (
            "decel_lim_theta: -3.2",
            "decel_lim_theta: 3.2",
            "FollowPath.decel_lim_theta; velocity_smoother.max_decel; below zero",
        ),
        (
            "max_velocity: [0.5, 0.0, 1.0]",
            "max_velocity: [0.5, 1.0]",
            "velocity_smoother.max_velocity is [0.5,1.0]; [x, y, theta]",
        ),
        (
            "min_vel_x: -0.1",
            "min_vel_x: 0.05",
            "FollowPath.min_vel_x; min_vel_x is 0.05; -15.99 to 0",
        ),
        (
            "max_vel_x: 0.45",
            "max_vel_x: -0.2",
            "FollowPath.max_vel_x; max_vel_x is -0.2; 0 to 15.99",
        ),
        ("[-0.35, 0.25] ]\"", "[-0.35] ]\"", "local_costmap.footprint; three corners"),
        (
            "[0.35, -0.25], [-0.35, -0.25]",
            "[-0.35, -0.25], [0.35, -0.25]",
            "local_costmap.footprint: the body's polygon is not valid: two of its edges cross",
        ),
        ("footprint_padding: 0.02", "footprint_padding: -1", "footprint_padding is -1; 0 to 100"),
        (
            "PathDist.scale: 32.0",
            "PathDist.scale: 32.0\n      PathDist: {scale: 1.0}",
            "FollowPath.PathDist.scale is given twice",
        ),
        ("sim_time: 1.7", "sim_time: 1.7\n      sim_time: 1.8", "duplicate key `sim_time`"),
        (
            "sim_time: 1.7",
            "sim_time: 5000.0",
            "FollowPath.sim_time; sim_time_s is 5000; at most 1000",
        ),
    ] {
        assert!(DWB.contains(from), "{from}");
        assert_rejected(&DWB.replace(from, to), None, words);
    }
}

#[test]
fn other_files_are_rejected() {
    for text in ["", "a: 1", "[1, 2]", "controller_server: 3", "amcl:\n  ros__parameters: {a: 1}"] {
        let error = import(text, None).expect_err(text).to_string();
        assert!(error.contains("ros__parameters") || error.contains("line 1"), "{text}: {error}");
    }
    assert_rejected(ROBOTS, None, "several robots; `robot1`, `robot2`; choose a namespace");
    assert_rejected(ROBOTS, Some("robot3"), "`robot3`; `robot1`, `robot2`");
    assert_rejected(DWB, Some("robot3"), "`robot3`; the root");
}

/// The reason is the controller, not a missing node.
#[test]
fn file_with_only_an_unsupported_controller_is_rejected_with_its_type() {
    let text = r#"
controller_server:
  ros__parameters:
    controller_plugins: ["FollowPath"]
    FollowPath:
      v_linear_max: 0.5
      plugin: "nav2_graceful_controller::GracefulController"
"#;
    let words = "controller_server.FollowPath.plugin; GracefulController: the import supports only DWB, MPPI";
    assert_rejected(text, None, words);
}

/// Aliases that expand to a billion values, and nesting of ten thousand levels.
#[test]
fn yaml_bombs_are_rejected() {
    let mut bomb =
        "controller_server:\n  ros__parameters:\n    a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]\n"
            .to_owned();
    for level in 1..10 {
        let before = format!("*a{}, ", level - 1).repeat(10);
        let line = format!("    a{level}: &a{level} [{}]\n", before.trim_end_matches(", "));
        bomb += &line;
    }
    assert!(import(&bomb, None).is_err());
    let deep = format!("controller_server: {}{}", "{a: ".repeat(10_000), "}".repeat(10_000));
    assert!(import(&deep, None).is_err());
    let listed = format!(
        "controller_server: {{ros__parameters: {{a: {}{}}}}}",
        "[".repeat(10_000),
        "]".repeat(10_000)
    );
    assert!(import(&listed, None).is_err());
}
