//! Parameter files of the usual kinds, written for these tests.

/// DWB, an older file: one progress checker by name, critics with dots, one nested.
pub const DWB: &str = r#"
amcl:
  ros__parameters: {alpha1: 0.2, scan_topic: scan}
controller_server:
  ros__parameters:
    use_sim_time: True
    controller_frequency: 20.0
    min_x_velocity_threshold: 0.001
    failure_tolerance: 0.3
    progress_checker_plugin: "progress_checker"
    goal_checker_plugins: ["precise", "rough"]
    controller_plugins: ["FollowPath", "Slow"]
    progress_checker:
      plugin: "nav2_controller::SimpleProgressChecker"
      required_movement_radius: 0.4
      movement_time_allowance: 12.0
    rough:
      plugin: "nav2_controller::SimpleGoalChecker"
      xy_goal_tolerance: 0.5
    precise:
      plugin: "nav2_controller::SimpleGoalChecker"
      xy_goal_tolerance: 0.15
      yaw_goal_tolerance: 6.28
      stateful: True
    FollowPath:
      plugin: "dwb_core::DWBLocalPlanner"
      debug_trajectory_details: True
      min_vel_x: -0.1
      min_vel_y: 0.0
      max_vel_x: 0.45
      max_speed_xy: 0.4
      min_speed_xy: 0.0
      max_vel_theta: 1.1
      acc_lim_x: 2.5
      acc_lim_y: 0.0
      acc_lim_theta: 3.2
      decel_lim_x: -2.5
      decel_lim_theta: -3.2
      vx_samples: 20
      vy_samples: 5
      vtheta_samples: 30
      sim_time: 1.7
      linear_granularity: 0.05
      xy_goal_tolerance: 0.25
      transform_tolerance: 0.2
      critics: ["RotateToGoal", "BaseObstacle", "PathDist"]
      BaseObstacle.scale: 0.02
      PathDist.scale: 32.0
      RotateToGoal: {scale: 32.0, slowing_factor: 5.0}
      max_vel_thta: 9.0
    Slow:
      plugin: "dwb_core::DWBLocalPlanner"
      max_vel_x: 0.1
local_costmap:
  local_costmap:
    ros__parameters:
      width: 3
      resolution: 0.05
      footprint: "[ [0.35, 0.25], [0.35, -0.25], [-0.35, -0.25], [-0.35, 0.25] ]"
      robot_radius: 0.22
      footprint_padding: 0.02
      plugins: ["obstacle_layer", "inflation_layer"]
      obstacle_layer:
        plugin: "nav2_costmap_2d::ObstacleLayer"
        scan: {topic: /scan, obstacle_max_range: 2.5}
      inflation_layer: {inflation_radius: 0.55, cost_scaling_factor: 3.0}
velocity_smoother:
  ros__parameters:
    smoothing_frequency: 30.0
    feedback: "OPEN_LOOP"
    max_velocity: [0.5, 0.0, 1.0]
    min_velocity: [-0.26, 0.0, -0.9]
    max_accel: [1.5, 0.0, 4.0]
    max_decel: [-3.0, 0.0, -3.0]
    deadband_velocity: [0.03, 0.0, 0.1]
    velocity_timeout: 0.8
"#;

/// MPPI in a rotation shim, with its parameters among the shim's.
pub const SHIM: &str = r#"
controller_server:
  ros__parameters:
    controller_frequency: 25.0
    costmap_update_timeout: 0.4
    progress_checker_plugins: ["progress"]
    controller_plugins: ["Other", "FollowPath"]
    progress: {plugin: "nav2_controller::PoseProgressChecker", required_movement_radius: 0.3, required_movement_angle: 0.5}
    Other:
      plugin: "nav2_regulated_pure_pursuit_controller::RegulatedPurePursuitController"
      desired_linear_vel: 0.5
    FollowPath:
      plugin: "nav2_rotation_shim_controller::RotationShimController"
      primary_controller: "nav2_mppi_controller::MPPIController"
      angular_dist_threshold: 0.2
      forward_sampling_distance: 0.5
      rotate_to_heading_angular_vel: 1.8
      simulate_ahead_time: 1.0
      time_steps: 56
      model_dt: 0.05
      batch_size: 2000
      vx_max: 0.5
      vx_min: -0.35
      vy_max: 0.5
      wz_max: 1.9
      ax_max: 3.0
      ax_min: -2.0
      az_max: 3.5
      vx_std: 0.2
      temperature: 0.3
      motion_model: "DiffDrive"
      critics: ["GoalCritic", "TwirlingCritic"]
      GoalCritic: {enabled: true, cost_weight: 5.0}
      TwirlingCritic: {twirling_cost_weight: 10.0}
      AckermannConstraints: {min_turning_r: 0.2}
"#;

/// Two robots, and parameters of every node of every robot.
pub const ROBOTS: &str = r#"
/**:
  ros__parameters:
    use_sim_time: false
    robot_radius: 0.3
    controller_frequency: 5.0
robot1:
  controller_server:
    ros__parameters:
      controller_frequency: 10.0
      FollowPath: {plugin: "dwb_core::DWBLocalPlanner", max_vel_x: 0.3}
  local_costmap:
    local_costmap:
      ros__parameters: {width: 3}
/robot2/controller_server:
  ros__parameters:
    FollowPath.plugin: "dwb_core::DWBLocalPlanner"
    FollowPath.max_vel_x: 0.6
"#;
