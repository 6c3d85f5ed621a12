//! How the navigator behaves, under the names that ROS users know where there is one.

use serde::{Deserialize, Serialize};

/// Distances, tolerances and patience. The defaults drive the default robot through mine drifts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct NavigatorSettings {
    /// The goal is reached when the robot stands within this distance of it, metres.
    pub xy_goal_tolerance: f64,
    /// Where the goal asks for a yaw, the robot turns until it is within this of it, radians.
    pub yaw_goal_tolerance: f64,
    /// Gap kept to everything beyond the footprint, metres, on top of the map's own coarseness.
    pub safety_margin_m: f64,
    /// Gap kept to moving obstacles, metres: they may turn round at any moment.
    pub moving_margin_m: f64,
    /// Extra distance to walls that the global path keeps where there is room, metres.
    pub comfort_margin_m: f64,
    /// Key nodes are at most this far apart along the path, metres.
    pub key_node_spacing_m: f64,
    /// The local target is the first key node at least this far ahead along the path, metres.
    pub lookahead_m: f64,
    /// The path is checked for new obstacles this far ahead, metres.
    pub check_ahead_m: f64,
    /// The robot turns in place when the target lies further off its heading than this, radians.
    pub turn_in_place_from: f64,
    /// It drives on when the target lies within this, radians.
    pub turn_in_place_until: f64,
    /// It tries something else after this long without an admissible sample or progress, seconds.
    pub patience_s: f64,
    /// Seconds between two attempts to plan anew.
    pub replan_period_s: f64,
    /// Progress along the path that counts as such, metres (Nav2: `required_movement_radius`).
    pub required_movement_radius: f64,
    /// The mission is given up after this long without progress, seconds.
    pub give_up_after_s: f64,
    /// Speed at which the robot backs out of a dead end, m/s.
    pub backing_speed: f64,
}

impl Default for NavigatorSettings {
    fn default() -> Self {
        Self {
            xy_goal_tolerance: 0.25,
            yaw_goal_tolerance: 0.1,
            safety_margin_m: 0.05,
            moving_margin_m: 0.35,
            comfort_margin_m: 0.25,
            key_node_spacing_m: 0.5,
            lookahead_m: 2.0,
            check_ahead_m: 8.0,
            turn_in_place_from: 1.2,
            turn_in_place_until: 0.3,
            patience_s: 3.0,
            replan_period_s: 2.0,
            required_movement_radius: 0.5,
            give_up_after_s: 90.0,
            backing_speed: 0.25,
        }
    }
}
