//! The rules of the import as tables: parameters, and the settings that follow from them or the reason why none does.

use super::UnmappedReason::{DifferentMeaning, NoEquivalent, NotInEffect, NotSupported};
use super::footprint::import_footprint;
use super::parameter_file::Parameters;
use super::rules::Conversion::{
    Angle, Count, Element, Negated, NegatedElement, NoReverse, Number, Period,
};
use super::rules::Rule::{self, Derive, Leave};
use super::rules::{
    at_least, at_most, motion_model, mppi_horizon, mppi_samples, rotation_thresholds, set,
};

const NO_TOPICS: &str = "the program has no ROS topics for it";
const NO_TF: &str = "the planner gets poses, not tf frames";
const NO_SIDEWAYS: &str = "tracks do not move sideways";
const PLUGIN_NAMES: &str = "it names the imported plugins";
const MEASURED_SPEEDS: &str = "the planner uses measured speeds without a threshold";
const GOAL_STOP: &str = "the robot parks, and stops when it has arrived";
const GOAL_AT_ONCE: &str = "position and yaw are checked at the same time";
const PATH_PROGRESS: &str = "the robot follows the path by its progress along it";
const FIXED_TERMS: &str = "the terms are fixed: heading, clearance, velocity and path, each with its weight in local.weights";
const NO_TERM: &str = "there is no such term";

/// Parameters of all nodes.
#[rustfmt::skip]
pub(super) const COMMON: &[Rule] = &[
    Leave("plugin", NoEquivalent, "it selects a plugin of Nav2"),
    Leave("use_sim_time", NoEquivalent, "the program does not use the ROS clock"),
    Leave("speed_limit_topic", NoEquivalent, "`inbye node` reads `speed_limit` in its namespace"),
    Leave("odom_topic", NoEquivalent, "`inbye node` reads `odom` in its namespace"),
    Leave("*_topic", NoEquivalent, NO_TOPICS),
    Leave("topic", NoEquivalent, NO_TOPICS),
    Leave("*_frame", NoEquivalent, NO_TF),
    Leave("*transform_tolerance", NoEquivalent, NO_TF),
    Leave("bond_*", NoEquivalent, "`inbye node --managed` has no bond: its lifecycle manager needs bond_timeout 0.0"),
    Leave("use_realtime_priority", NoEquivalent, "the process keeps its priority"),
    Leave("introspection_mode", NoEquivalent, "the action of `inbye node` has no introspection"),
];

#[rustfmt::skip]
pub(super) const CONTROLLER_SERVER: &[Rule] = &[
    set("controller_frequency", "local.control_period_s").convert(Period, "1 / controller_frequency, within the 4 to 100 Hz of `inbye node`"),
    set("costmap_update_timeout", "navigator.scan_timeout_s"),
    Leave("min_x_velocity_threshold", NoEquivalent, MEASURED_SPEEDS),
    Leave("min_y_velocity_threshold", NoEquivalent, MEASURED_SPEEDS),
    Leave("min_theta_velocity_threshold", NoEquivalent, MEASURED_SPEEDS),
    Leave("failure_tolerance", DifferentMeaning, "in Nav2 the controller then fails; here the robot brakes at once and starts an escape after navigator.stuck_patience_s"),
    Leave("progress_checker_plugin", NoEquivalent, PLUGIN_NAMES),
    Leave("progress_checker_plugins", NoEquivalent, PLUGIN_NAMES),
    Leave("goal_checker_plugin", NoEquivalent, PLUGIN_NAMES),
    Leave("goal_checker_plugins", NoEquivalent, PLUGIN_NAMES),
    Leave("controller_plugins", NoEquivalent, PLUGIN_NAMES),
    Leave("publish_zero_velocity", NoEquivalent, "the base always gets zero velocity at the end"),
    Leave("action_server_result_timeout", NoEquivalent, "`inbye node` keeps the results of the last 16 goals"),
    Leave("enable_stamped_cmd_vel", NoEquivalent, "it is an option of `inbye node`"),
    Leave("search_window", NoEquivalent, PATH_PROGRESS),
];

#[rustfmt::skip]
pub(super) const PROGRESS_CHECKER: &[Rule] = &[
    set("required_movement_radius", "navigator.required_movement_radius"),
    Leave("movement_time_allowance", DifferentMeaning, "in Nav2 a recovery then starts; here it starts after navigator.stuck_patience_s, and navigator.movement_time_allowance ends the mission"),
    Leave("required_movement_angle", NoEquivalent, "progress is measured along the path"),
];

#[rustfmt::skip]
pub(super) const GOAL_CHECKER: &[Rule] = &[
    set("xy_goal_tolerance", "navigator.xy_goal_tolerance"),
    set("yaw_goal_tolerance", "navigator.yaw_goal_tolerance").convert(Angle, "above pi: any yaw"),
    Leave("stateful", NoEquivalent, GOAL_AT_ONCE),
    Leave("trans_stopped_velocity", NoEquivalent, GOAL_STOP),
    Leave("rot_stopped_velocity", NoEquivalent, GOAL_STOP),
    Leave("path_length_tolerance", NoEquivalent, PATH_PROGRESS),
];

const TIME_STEPS: &str = "poses are checked at even time steps: local.sim_step_s";
const PATH_COST: &str = "a cost in cells of the costmap, added without normalization; local.weights.path weights the distance to the key node, normalized over all samples";
const HEADING_COST: &str = "a cost in cells of the costmap, added without normalization; local.weights.heading weights the angle to the target, normalized over all samples";

fn has_speed_limit(parameters: &Parameters) -> bool {
    let limit = parameters.peek("max_speed_xy").and_then(serde_json::Value::as_f64);
    limit.is_none_or(|limit| limit >= 0.0)
}

fn has_time_steps(parameters: &Parameters) -> bool {
    parameters.peek("discretize_by_time") == Some(&serde_json::Value::Bool(true))
}

/// Nav2's implementation of the dynamic window approach. Speeds, samples and horizon have the same meaning, critics do not.
#[rustfmt::skip]
pub(super) const DWB: &[Rule] = &[
    at_most("max_vel_x", "robot.limits.max_vel_x"),
    at_most("max_vel_theta", "robot.limits.max_vel_theta"),
    at_most("acc_lim_x", "robot.limits.acc_lim_x"),
    at_most("acc_lim_theta", "robot.limits.acc_lim_theta"),
    at_least("min_vel_x", "robot.limits.min_vel_x").or_default(0.0),
    at_least("decel_lim_x", "robot.limits.decel_lim_x"),
    at_least("decel_lim_theta", "robot.limits.decel_lim_theta"),
    at_most("max_speed_xy", "robot.limits.max_vel_x").convert(Number, "in any direction").when(has_speed_limit),
    set("vx_samples", "local.vx_samples").convert(Count, ""),
    set("vtheta_samples", "local.vtheta_samples").convert(Count, ""),
    set("sim_time", "local.sim_time_s"),
    set("time_granularity", "local.sim_step_s").when(has_time_steps),
    Leave("min_vel_y", NoEquivalent, NO_SIDEWAYS),
    Leave("max_vel_y", NoEquivalent, NO_SIDEWAYS),
    Leave("acc_lim_y", NoEquivalent, NO_SIDEWAYS),
    Leave("decel_lim_y", NoEquivalent, NO_SIDEWAYS),
    Leave("vy_samples", NoEquivalent, NO_SIDEWAYS),
    Leave("max_speed_xy", NotInEffect, "negative: no limit"),
    Leave("min_speed_xy", NoEquivalent, "there is no lowest speed: the robot may stop"),
    Leave("min_speed_theta", NoEquivalent, "there is no lowest turn rate: the robot may drive straight"),
    Leave("linear_granularity", DifferentMeaning, TIME_STEPS),
    Leave("angular_granularity", DifferentMeaning, TIME_STEPS),
    Leave("time_granularity", NotInEffect, "it needs discretize_by_time, which is false"),
    Leave("discretize_by_time", NoEquivalent, TIME_STEPS),
    Leave("include_last_point", NoEquivalent, "the last pose is always checked"),
    Leave("limit_vel_cmd_in_traj", NoEquivalent, "the speed limits always apply"),
    Leave("short_circuit_trajectory_evaluation", NoEquivalent, "samples that cannot win are always skipped; the result is the same"),
    Leave("trans_stopped_velocity", NoEquivalent, GOAL_STOP),
    Leave("rot_stopped_velocity", NoEquivalent, GOAL_STOP),
    Leave("xy_goal_tolerance", DifferentMeaning, "it belongs to the critic RotateToGoal; the goal checker's tolerance is navigator.xy_goal_tolerance"),
    Leave("yaw_goal_tolerance", DifferentMeaning, "it belongs to the critic RotateToGoal; the goal checker's tolerance is navigator.yaw_goal_tolerance"),
    Leave("stateful", NoEquivalent, GOAL_AT_ONCE),
    Leave("prune_plan", NoEquivalent, PATH_PROGRESS),
    Leave("prune_distance", NoEquivalent, PATH_PROGRESS),
    Leave("shorten_transformed_plan", NoEquivalent, PATH_PROGRESS),
    Leave("forward_prune_distance", DifferentMeaning, "navigator.lookahead_m selects the local target"),
    Leave("trajectory_generator_name", NoEquivalent, "there is one generator: constant velocities over the horizon"),
    Leave("goal_checker_name", NoEquivalent, "there is one goal checker"),
    Leave("default_critic_namespaces", NoEquivalent, FIXED_TERMS),
    Leave("critics", NoEquivalent, FIXED_TERMS),
    Leave("debug_trajectory_details", NoEquivalent, "`inbye evaluate` explains a decision"),
    Leave("publish_*", NoEquivalent, NO_TOPICS),
    Leave("marker_lifetime", NoEquivalent, NO_TOPICS),
    Leave("PathDist.*", DifferentMeaning, PATH_COST),
    Leave("PathAlign.*", DifferentMeaning, PATH_COST),
    Leave("GoalDist.*", DifferentMeaning, HEADING_COST),
    Leave("GoalAlign.*", DifferentMeaning, HEADING_COST),
    Leave("BaseObstacle.*", DifferentMeaning, "a cost of the costmap; local.weights.clearance weights the distance to the nearest obstacle, normalized over all samples"),
    Leave("ObstacleFootprint.*", DifferentMeaning, "a cost of the costmap; the discs of the footprint are always checked"),
    Leave("RotateToGoal.*", NoEquivalent, "the navigator parks and rotates at the goal"),
    Leave("Oscillation.*", NoEquivalent, NO_TERM),
    Leave("PreferForward.*", DifferentMeaning, "local.weights.velocity weights the forward speed, normalized over all samples"),
    Leave("Twirling.*", NoEquivalent, NO_TERM),
    Leave("MapGrid*", NoEquivalent, NO_TERM),
];

fn has_desired_speed(parameters: &Parameters) -> bool {
    parameters.peek("desired_linear_vel").is_some() || parameters.peek("max_linear_vel").is_none()
}

fn never_reverses(parameters: &Parameters) -> bool {
    parameters.peek("allow_reversing") != Some(&serde_json::Value::Bool(true))
}

/// Nav2's Regulated Pure Pursuit: only its limits have a meaning for the dynamic window. The highest speed is `desired_linear_vel` in older
/// versions, `max_linear_vel` in newer ones.
#[rustfmt::skip]
pub(super) const PURE_PURSUIT: &[Rule] = &[
    at_most("desired_linear_vel", "robot.limits.max_vel_x").or_default(0.5).when(has_desired_speed),
    at_most("max_linear_vel", "robot.limits.max_vel_x"),
    at_most("max_angular_vel", "robot.limits.max_vel_theta"),
    at_least("allow_reversing", "robot.limits.min_vel_x").convert(NoReverse, "false: no reverse").or_default(0.0).when(never_reverses),
    Leave("allow_reversing", NoEquivalent, "true: the robot reverses at up to robot.limits.min_vel_x, which keeps its value"),
    Leave("*", NotSupported, "of Regulated Pure Pursuit: the import supports only its highest speeds and allow_reversing"),
];

const WINDOW_GRID: &str =
    "the dynamic window is sampled on a grid, without noise, and each decision is independent";
const MPPI_COST: &str = "a critic of MPPI, whose cost is added without normalization; local.weights weights terms that are normalized over all samples";
const DIFF_DRIVE: &str = "the robot has tracks, which Nav2 calls DiffDrive";
const NO_CUSPS: &str = "paths have no cusps";

/// Nav2's model predictive path integral controller. Limits and horizon have the same meaning, noise and critics do not.
#[rustfmt::skip]
pub(super) const MPPI: &[Rule] = &[
    at_most("vx_max", "robot.limits.max_vel_x").or_default(0.5),
    at_most("wz_max", "robot.limits.max_vel_theta"),
    at_most("ax_max", "robot.limits.acc_lim_x"),
    at_least("vx_min", "robot.limits.min_vel_x"),
    at_least("ax_min", "robot.limits.decel_lim_x"),
    at_most("az_max", "robot.limits.acc_lim_theta"),
    at_least("az_max", "robot.limits.decel_lim_theta").convert(Negated, "negative, for braking"),
    Derive(&["model_dt", "time_steps"], mppi_horizon),
    Derive(&["batch_size"], mppi_samples),
    Leave("vy_*", NoEquivalent, NO_SIDEWAYS),
    Leave("ay_*", NoEquivalent, NO_SIDEWAYS),
    Leave("vx_std", NoEquivalent, WINDOW_GRID),
    Leave("wz_std", NoEquivalent, WINDOW_GRID),
    Leave("temperature", NoEquivalent, WINDOW_GRID),
    Leave("gamma", NoEquivalent, WINDOW_GRID),
    Leave("iteration_count", NoEquivalent, WINDOW_GRID),
    Leave("regenerate_noises", NoEquivalent, WINDOW_GRID),
    Leave("dump_noises", NoEquivalent, WINDOW_GRID),
    Leave("advanced.*", NoEquivalent, WINDOW_GRID),
    Leave("open_loop", NoEquivalent, "decisions start from the measured speed"),
    Leave("retry_attempt_limit", NoEquivalent, "without an admissible sample the robot brakes and then escapes"),
    Leave("reset_period", NoEquivalent, "a decision keeps no state of the one before"),
    Derive(&["motion_model"], motion_model),
    Leave("motion_model", NoEquivalent, DIFF_DRIVE),
    Leave("AckermannConstraints.*", NoEquivalent, "a tracked robot rotates in place"),
    Leave("*Constraints", NoEquivalent, DIFF_DRIVE),
    Leave("prune_distance", NoEquivalent, PATH_PROGRESS),
    Leave("max_robot_pose_search_dist", NoEquivalent, PATH_PROGRESS),
    Leave("enforce_path_inversion", NoEquivalent, NO_CUSPS),
    Leave("enforce_path_rotation", NoEquivalent, NO_CUSPS),
    Leave("inversion_*", NoEquivalent, NO_CUSPS),
    Leave("visualize", NoEquivalent, NO_TOPICS),
    Leave("publish_*", NoEquivalent, NO_TOPICS),
    Leave("Visualization.*", NoEquivalent, NO_TOPICS),
    Leave("TrajectoryVisualizer.*", NoEquivalent, NO_TOPICS),
    Leave("trajectory_step", NoEquivalent, NO_TOPICS),
    Leave("time_step", NoEquivalent, NO_TOPICS),
    Leave("TrajectoryValidator.*", NoEquivalent, "every sample is checked for contact"),
    Leave("critics", NoEquivalent, FIXED_TERMS),
    Leave("ConstraintCritic.*", NoEquivalent, "all samples are within the limits"),
    Leave("CostCritic.*", DifferentMeaning, MPPI_COST),
    Leave("ObstaclesCritic.*", DifferentMeaning, MPPI_COST),
    Leave("GoalCritic.*", DifferentMeaning, MPPI_COST),
    Leave("GoalAngleCritic.*", DifferentMeaning, MPPI_COST),
    Leave("PathAlignCritic.*", DifferentMeaning, MPPI_COST),
    Leave("PathAngleCritic.*", DifferentMeaning, MPPI_COST),
    Leave("PathFollowCritic.*", DifferentMeaning, MPPI_COST),
    Leave("PreferForwardCritic.*", DifferentMeaning, MPPI_COST),
    Leave("TwirlingCritic.*", NoEquivalent, NO_TERM),
    Leave("VelocityDeadbandCritic.*", NoEquivalent, "there is no such term; the deadband of a base is base.tracks.deadband"),
    Leave("SymmetricYawBias*", NoEquivalent, NO_TERM),
];

/// Nav2's rotation shim first rotates the robot in place, as the navigator does.
#[rustfmt::skip]
pub(super) const ROTATION_SHIM: &[Rule] = &[
    Derive(&["angular_dist_threshold", "angular_disengage_threshold"], rotation_thresholds),
    Leave("primary_controller", NoEquivalent, "it names the imported controller"),
    Leave("forward_sampling_distance", DifferentMeaning, "the angle is measured to the local target: navigator.lookahead_m"),
    Leave("rotate_to_heading_angular_vel", NoEquivalent, "the robot rotates in place at up to robot.limits.max_vel_theta"),
    Leave("max_angular_accel", NoEquivalent, "the robot rotates in place within robot.limits.acc_lim_theta"),
    Leave("simulate_ahead_time", NoEquivalent, "rotations in place are checked as all motion is"),
    Leave("rotate_to_goal_heading", NoEquivalent, "the robot always rotates to the yaw of the goal"),
    Leave("rotate_to_heading_once", NoEquivalent, "the robot rotates in place whenever the angle is too large"),
    Leave("use_path_orientations", NoEquivalent, "paths have no yaws of their own"),
    Leave("closed_loop", NoEquivalent, "decisions start from the measured speed"),
];

/// The velocity smoother limits the commands of the controller, so the tighter of both limits applies.
#[rustfmt::skip]
pub(super) const VELOCITY_SMOOTHER: &[Rule] = &[
    at_most("max_velocity", "robot.limits.max_vel_x").convert(Element(0), "along x"),
    at_most("max_velocity", "robot.limits.max_vel_theta").convert(Element(2), "about z"),
    at_least("min_velocity", "robot.limits.min_vel_x").convert(Element(0), "along x"),
    at_most("min_velocity", "robot.limits.max_vel_theta").convert(NegatedElement(2), "about z, without its sign"),
    at_most("max_accel", "robot.limits.acc_lim_x").convert(Element(0), "along x"),
    at_most("max_accel", "robot.limits.acc_lim_theta").convert(Element(2), "about z"),
    at_least("max_decel", "robot.limits.decel_lim_x").convert(Element(0), "along x"),
    at_least("max_decel", "robot.limits.decel_lim_theta").convert(Element(2), "about z"),
    set("smoothing_frequency", "supervisor.rate_hz"),
    set("velocity_timeout", "supervisor.target_timeout_s"),
    set("deadband_velocity", "base.tracks.deadband").convert(Element(0), "along x, for each track"),
    Leave("scale_velocities", NoEquivalent, "a track's limit never changes the curvature"),
    Leave("feedback", NoEquivalent, "ramps always start from the last command"),
    Leave("odom_duration", NoEquivalent, MEASURED_SPEEDS),
    Leave("enable_stamped_cmd_vel", NoEquivalent, "it is an option of `inbye node`"),
    Leave("stamp_smoothed_velocity_with_smoothing_time", NoEquivalent, NO_TOPICS),
];

const NO_COSTMAP: &str = "there is no costmap: the local field has the map's resolution, and the size that the horizon needs";
const NO_LAYERS: &str =
    "there are no layers: map and scans are always obstacles, and moving obstacles are tracked";
const NO_INFLATION: &str =
    "distances to obstacles are weighted without inflation, up to local.max_clearance_m";
const SCAN_MAX: &str =
    "the scan's own range applies; the simulated lidar has simulation.lidar.range_max_m";
const SCAN_MIN: &str =
    "the scan's own range applies; the simulated lidar has simulation.lidar.range_min_m";

/// Only the footprint of the local costmap is imported.
#[rustfmt::skip]
pub(super) const LOCAL_COSTMAP: &[Rule] = &[
    Derive(&["footprint", "robot_radius", "footprint_padding"], import_footprint),
    Leave("robot_radius", NotInEffect, "footprint overrides it"),
    Leave("footprint", NotInEffect, "empty"),
    Leave("footprint_padding", NotInEffect, "there is no footprint to pad"),
    Leave("inflation_radius", DifferentMeaning, NO_INFLATION),
    Leave("cost_scaling_factor", DifferentMeaning, NO_INFLATION),
    Leave("*.inflation_radius", DifferentMeaning, NO_INFLATION),
    Leave("*.cost_scaling_factor", DifferentMeaning, NO_INFLATION),
    Leave("*obstacle_max_range", DifferentMeaning, SCAN_MAX),
    Leave("*raytrace_max_range", DifferentMeaning, SCAN_MAX),
    Leave("*obstacle_min_range", DifferentMeaning, SCAN_MIN),
    Leave("*raytrace_min_range", DifferentMeaning, SCAN_MIN),
    Leave("width", NoEquivalent, NO_COSTMAP),
    Leave("height", NoEquivalent, NO_COSTMAP),
    Leave("resolution", NoEquivalent, NO_COSTMAP),
    Leave("origin_x", NoEquivalent, NO_COSTMAP),
    Leave("origin_y", NoEquivalent, NO_COSTMAP),
    Leave("rolling_window", NoEquivalent, NO_COSTMAP),
    Leave("update_frequency", NoEquivalent, "the field is computed for each decision"),
    Leave("publish_frequency", NoEquivalent, NO_TOPICS),
    Leave("always_send_full_costmap", NoEquivalent, NO_TOPICS),
    Leave("track_unknown_space", DifferentMeaning, "the setting unknown is \"blocked\" or \"free\""),
    Leave("unknown_cost_value", NoEquivalent, NO_LAYERS),
    Leave("lethal_cost_threshold", NoEquivalent, "the map file has the thresholds"),
    Leave("trinary_costmap", NoEquivalent, "the map file has the mode"),
    Leave("initial_transform_timeout", NoEquivalent, NO_TF),
    Leave("map_vis_z", NoEquivalent, NO_TOPICS),
    Leave("plugins", NoEquivalent, NO_LAYERS),
    Leave("filters", NoEquivalent, "it names the costmap filters: masks are files of --keepout and --speed-zones, or topics of `inbye node`"),
    Leave("observation_sources", NoEquivalent, NO_LAYERS),
    Leave("subscribe_to_stamped_footprint", NoEquivalent, NO_TOPICS),
    // All other nested parameters belong to layers.
    Leave("*.*", NoEquivalent, NO_LAYERS),
];
