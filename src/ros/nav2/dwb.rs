//! DWB, Nav2's dynamic window: its speeds, samples and horizon mean the same here, its critics do not.

use super::draft::Draft;
use super::leftovers::Rule;
use super::section::Section;
use super::{Nav2Error, Why};

pub(super) const PLUGIN: &str = "dwb_core::DWBLocalPlanner";

pub(super) const MAPPED: [&str; 11] = [
    "min_vel_x",
    "max_vel_x",
    "max_speed_xy",
    "max_vel_theta",
    "acc_lim_x",
    "acc_lim_theta",
    "decel_lim_x",
    "decel_lim_theta",
    "vx_samples",
    "vtheta_samples",
    "sim_time",
];

const SIDEWAYS: &str = "tracks do not move sideways";
const BY_TIME: &str = "checked poses are evenly spaced in time: local.sim_step_s";
const PATH: &str = "a cost in cells of the costmap, added as it is; local.weights.path weighs the distance to the key node, normalised over all samples";
const HEADING: &str = "a cost in cells of the costmap, added as it is; local.weights.heading weighs the angle to the target, normalised over all samples";
const FIXED: &str = "no critics to choose: heading, clearance, velocity and path, each with its weight in local.weights";

pub(super) const RULES: [Rule; 36] = [
    ("min_vel_y", Why::NoSuchThing, SIDEWAYS),
    ("max_vel_y", Why::NoSuchThing, SIDEWAYS),
    ("acc_lim_y", Why::NoSuchThing, SIDEWAYS),
    ("decel_lim_y", Why::NoSuchThing, SIDEWAYS),
    ("vy_samples", Why::NoSuchThing, SIDEWAYS),
    ("max_speed_xy", Why::NotInForce, "negative: no limit"),
    (
        "min_speed_xy",
        Why::NoSuchThing,
        "no lowest speed but min_vel_x: the robot may stand",
    ),
    (
        "min_speed_theta",
        Why::NoSuchThing,
        "no lowest turn rate: the robot may drive straight on",
    ),
    ("linear_granularity", Why::OtherMeaning, BY_TIME),
    ("angular_granularity", Why::OtherMeaning, BY_TIME),
    (
        "time_granularity",
        Why::NotInForce,
        "it counts with discretize_by_time only, which is false",
    ),
    ("discretize_by_time", Why::NoSuchThing, BY_TIME),
    (
        "include_last_point",
        Why::NoSuchThing,
        "the last pose is always checked",
    ),
    (
        "limit_vel_cmd_in_traj",
        Why::NoSuchThing,
        "the limits of speed always hold",
    ),
    (
        "short_circuit_trajectory_evaluation",
        Why::NoSuchThing,
        "what cannot win is always left out; the result is the same",
    ),
    (
        "trans_stopped_velocity",
        Why::NoSuchThing,
        "the robot parks, and stands when it has arrived",
    ),
    (
        "rot_stopped_velocity",
        Why::NoSuchThing,
        "the robot parks, and stands when it has arrived",
    ),
    (
        "xy_goal_tolerance",
        Why::OtherMeaning,
        "of the critic RotateToGoal; the goal checker's is navigator.xy_goal_tolerance",
    ),
    (
        "yaw_goal_tolerance",
        Why::OtherMeaning,
        "of the critic RotateToGoal; the goal checker's is navigator.yaw_goal_tolerance",
    ),
    (
        "stateful",
        Why::NoSuchThing,
        "arrival is judged by position and yaw at once",
    ),
    (
        "prune_plan",
        Why::NoSuchThing,
        "the path is followed by progress along it",
    ),
    (
        "prune_distance",
        Why::NoSuchThing,
        "the path is followed by progress along it",
    ),
    (
        "shorten_transformed_plan",
        Why::NoSuchThing,
        "the path is followed by progress along it",
    ),
    (
        "forward_prune_distance",
        Why::OtherMeaning,
        "navigator.lookahead_m chooses the local target",
    ),
    (
        "trajectory_generator_name",
        Why::NoSuchThing,
        "one generator: velocities held over the horizon",
    ),
    ("goal_checker_name", Why::NoSuchThing, "one goal checker"),
    ("default_critic_namespaces", Why::NoSuchThing, FIXED),
    ("critics", Why::NoSuchThing, FIXED),
    (
        "debug_trajectory_details",
        Why::NoSuchThing,
        "`inbye evaluate --samples` explains a decision",
    ),
    ("publish_*", Why::NoSuchThing, "no ROS topics"),
    ("marker_lifetime", Why::NoSuchThing, "no ROS topics"),
    ("PathDist.*", Why::OtherMeaning, PATH),
    ("PathAlign.*", Why::OtherMeaning, PATH),
    ("GoalDist.*", Why::OtherMeaning, HEADING),
    ("GoalAlign.*", Why::OtherMeaning, HEADING),
    (
        "BaseObstacle.*",
        Why::OtherMeaning,
        "a cost of the costmap; local.weights.clearance weighs the distance to the nearest obstacle, normalised over all samples",
    ),
];

/// Critics that have nothing like them here.
pub(super) const CRITICS: [Rule; 6] = [
    (
        "ObstacleFootprint.*",
        Why::OtherMeaning,
        "a cost of the costmap; the footprint's discs are always checked",
    ),
    (
        "RotateToGoal.*",
        Why::NoSuchThing,
        "the navigator parks and turns at the goal itself",
    ),
    ("Oscillation.*", Why::NoSuchThing, "no such term"),
    (
        "PreferForward.*",
        Why::OtherMeaning,
        "local.weights.velocity weighs the forward speed, normalised over all samples",
    ),
    ("Twirling.*", Why::NoSuchThing, "no such term"),
    ("MapGrid*", Why::NoSuchThing, "no such term"),
];

pub(super) fn take(part: &mut Section, draft: &mut Draft) -> Result<(), Nav2Error> {
    for (name, key) in [
        ("max_vel_x", "robot.limits.max_vel_x"),
        ("max_vel_theta", "robot.limits.max_vel_theta"),
        ("acc_lim_x", "robot.limits.acc_lim_x"),
        ("acc_lim_theta", "robot.limits.acc_lim_theta"),
    ] {
        if let Some(given) = part.number(name)? {
            draft.at_most(key, given, "");
        }
    }
    for (name, key) in [
        ("min_vel_x", "robot.limits.min_vel_x"),
        ("decel_lim_x", "robot.limits.decel_lim_x"),
        ("decel_lim_theta", "robot.limits.decel_lim_theta"),
    ] {
        if let Some(given) = part.number(name)? {
            draft.at_least(key, given, "");
        }
    }
    // A negative one is none.
    if part.peek("max_speed_xy").is_none_or(|most| most >= 0.0)
        && let Some(given) = part.number("max_speed_xy")?
    {
        draft.at_most(
            "robot.limits.max_vel_x",
            given,
            "in any direction, so also ahead",
        );
    }
    for (name, key) in [
        ("vx_samples", "local.vx_samples"),
        ("vtheta_samples", "local.vtheta_samples"),
    ] {
        if let Some(given) = part.count(name)? {
            draft.set(key, given, "");
        }
    }
    if let Some(given) = part.number("sim_time")? {
        draft.set("local.sim_time_s", given, "");
    }
    if part.flag("discretize_by_time")
        && let Some(given) = part.number("time_granularity")?
    {
        draft.set("local.sim_step_s", given, "");
    }
    Ok(())
}
