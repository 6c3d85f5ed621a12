//! Settings of the navigator, under Nav2's names where Nav2 has one.

use serde::{Deserialize, Serialize};

use crate::settings::{require, settings};

settings! {
    /// Distances, tolerances and times of the navigator. The defaults drive the default robot through mine roadways.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct NavigatorSettings {
        /// The goal is reached when the robot stands within this distance of it.
        pub xy_goal_tolerance: f64 = 0.25, ["m", above 0 to 10000];
        /// Where the goal has a yaw, the robot must stand within this of it.
        pub yaw_goal_tolerance: f64 = 0.1, ["rad", above 0 to pi];
        /// Within `xy_goal_tolerance` the robot parks: it tries to stand within this distance of the goal. A robot that stands within
        /// four times this distance when it gets the goal stays there. One that people made leave its goal parks within the goal's
        /// tolerances when it is back. A moving robot brakes once it would stand within half of them.
        pub xy_parking_tolerance: f64 = 0.006, ["m", above 0 to 10000];
        /// Parking tries to stand within this of the goal's yaw.
        pub yaw_parking_tolerance: f64 = 0.003, ["rad", above 0 to pi];
        /// The robot parks straight at a goal ahead that is nearer than this.
        pub parking_distance_m: f64 = 1.0, ["m", 0 to 10000];
        /// After this time a parking robot has arrived if it stands within the goal's tolerances.
        pub parking_timeout_s: f64 = 30.0, ["s", 0 to 10000];
        /// Least speed of a parking robot that moves (Nav2: `min_approach_linear_velocity`). It must be above the speed at which
        /// the base starts to move.
        pub min_approach_linear_velocity: f64 = 0.05, ["m/s", above 0 to 15.99];
        /// Least turn rate of a parking robot that rotates (Nav2: `min_rotational_vel`), likewise.
        pub min_rotational_vel: f64 = 0.08, ["rad/s", above 0 to 10000];
        /// The robot has stopped when speed and turn rate have been measured as nearly zero for this long.
        pub stopped_time_s: f64 = 0.3, ["s", 0 to 10000];
        /// Pause at each waypoint.
        pub waypoint_pause_s: f64 = 5.0, ["s", 0 to 10000];
        /// Least time from a command to its effect. The navigator predicts the robot's motion until then, and for longer
        /// where the drive shows a longer latency.
        pub actuation_delay_s: f64 = 0.08, ["s", 0 to 10000];
        /// Whether latency, acceleration, braking and turn ratio of the base are identified while it drives, and used.
        pub identify_motion: bool = true;
        /// Time from a command to its effect that is assumed until the drive has shown it: about a second after the start.
        pub unidentified_delay_s: f64 = 0.3, ["s", 0 to 2];
        /// Speed of a walking person (ISO 13855). A person behind a corner may come out at this speed, and a standing person
        /// may reach it.
        pub pedestrian_speed: f64 = 1.6, ["m/s", 0 to 100];
        /// Least assumed radius of a moving obstacle: a lidar at the height of shins sees only the legs of a person.
        pub pedestrian_radius_m: f64 = 0.3, ["m", 0 to 2];
        /// Acceleration of a person or another moving obstacle.
        pub pedestrian_acceleration: f64 = 1.0, ["m/s^2", 0 to 10000];
        /// The robot drives at least this fast past places that may hide a person.
        pub occlusion_min_speed: f64 = 0.3, ["m/s", above 0 to 15.99];
        /// Whether the robot may reverse, evade and escape into space that its lidar does not see. Only for a robot without a
        /// view to the back, in a place without people.
        pub may_enter_unseen: bool = false;
        /// Distance that the robot keeps to static obstacles, on top of the margin for the map's resolution.
        pub safety_margin_m: f64 = 0.05, ["m", 0 to 10000];
        /// Distance that the robot keeps to moving obstacles: they may turn at any moment.
        pub moving_margin_m: f64 = 0.35, ["m", 0 to 10000];
        /// Distance that the robot keeps to an obstacle that came within that margin: enough to pass slowly.
        pub passing_margin_m: f64 = 0.15, ["m", 0 to 10000];
        /// Highest speed while an obstacle is within its margin.
        pub passing_speed: f64 = 0.3, ["m/s", above 0 to 15.99];
        /// Additional distance to walls that the global path keeps where there is room.
        pub comfort_margin_m: f64 = 0.25, ["m", 0 to 10000];
        /// A path that keeps it may be at most this many times as long as one that does not.
        pub comfort_detour: f64 = 1.5, ["", 1 to 10000];
        /// Largest distance between two key nodes along the path.
        pub key_node_spacing_m: f64 = 0.5, ["m", 0.01 to 10000];
        /// The local target is the first key node at least this far ahead along the path, if it is in sight. With
        /// less than the distance driven within the horizon the robot drives slowly.
        pub lookahead_m: f64 = 3.0, ["m", above 0 to 10000];
        /// Where that key node is not in sight, a nearer one is, at least this far ahead. On a path through a narrow passage
        /// 0.1 m is enough.
        pub min_lookahead_m: f64 = 0.3, ["m", 0 to 10000];
        /// The path is checked for new obstacles this far ahead, as far as the local window shows.
        pub path_check_distance_m: f64 = 8.0, ["m", 0 to 10000];
        /// The robot rotates in place when the target lies further off its heading than this.
        pub rotate_in_place_from: f64 = 1.2, ["rad", above 0 to pi];
        /// The rotation ends when the target lies within this of the heading, at most `rotate_in_place_from`.
        pub rotate_in_place_until: f64 = 0.3, ["rad", above 0];
        /// The robot escapes after it has stood or crept for this long.
        pub stuck_patience_s: f64 = 3.0, ["s", 0 to 10000];
        /// Shortest time between two requests for a plan.
        pub replan_period_s: f64 = 0.5, ["s", 0 to 10000];
        /// Age of a scan from which the robot brakes: Nav2's `costmap_update_timeout`.
        pub scan_timeout_s: f64 = 0.3, ["s", above 0 to 10000];
        /// Age of the odometry from which the robot brakes.
        pub odometry_timeout_s: f64 = 0.3, ["s", above 0 to 10000];
        /// Age of the pose in the map from which the robot brakes: odometry alone drifts.
        pub pose_timeout_s: f64 = 1.0, ["s", above 0 to 10000];
        /// The mission fails after faulty observations for this long.
        pub sensor_fault_patience_s: f64 = 3.0, ["s", 0 to 10000];
        /// The mission fails after the localisation has not known the pose, or the lidar has been blind, for this long; the
        /// robot stands meanwhile.
        pub localization_patience_s: f64 = 30.0, ["s", 0 to 10000];
        /// Time from the request for a plan until the robot follows it; planning runs on its own thread.
        pub planning_budget_s: f64 = 0.1, ["s", 0 to 10000];
        /// Whether the control loop waits for a plan that takes longer than that. A simulated run is then the same at
        /// each repetition. The commands that drive a real robot ignore this setting: they never wait, and take the plan when it is
        /// ready. A program that drives one by its own loop switches it off.
        pub wait_for_plans: bool = true;
        /// Longest duration of a decision, such as 0.05; a later decision is not sent. Without a value no decision of a
        /// simulated robot is late, and a run is the same at each repetition; a real robot has one control period.
        pub deadline_s: Option<f64> = None, ["s", above 0 to 10000];
        /// An obstacle that has blocked the path for this long is taken to stay, however long the detour is.
        pub detour_patience_s: f64 = 10.0, ["s", 0 to 10000];
        /// The robot takes a shortcut that saves at least this share of the remaining path.
        pub min_shortcut_share: f64 = 0.1, ["", 0 to 1];
        /// Shortest advance along the path that counts as progress (Nav2: `required_movement_radius`).
        pub required_movement_radius: f64 = 0.5, ["m", above 0 to 10000];
        /// The mission fails after this long without progress (Nav2: `movement_time_allowance`), or after twice as long if the robot now
        /// drives ahead along its path.
        pub movement_time_allowance: f64 = 90.0, ["s", above 0 to 10000];
        /// Speed at which the robot escapes.
        pub escape_speed: f64 = 0.25, ["m/s", above 0 to 15.99];
        /// Features beyond the dynamic window.
        pub features: NavigatorFeatures = NavigatorFeatures::default();
    }
    rule |settings| require(
        settings.rotate_in_place_until <= settings.rotate_in_place_from,
        "rotate_in_place_until",
        settings.rotate_in_place_until,
        "above zero and at most rotate_in_place_from",
    )
}

settings! {
    /// What the navigator does beyond the dynamic window. All is on by default; without a feature an experiment shows what it
    /// gains.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct NavigatorFeatures {
        /// The robot follows a global path. Off: the goal itself is the local target.
        pub global_path: bool = true;
        /// The robot passes key nodes, half a metre apart, by progress along the path. Off: the local targets are the
        /// nodes of the pruned path, and the robot must touch each before the next, as in the paper (section 3.3.3,
        /// step 4).
        pub progress: bool = true;
        /// Moving obstacles are tracked and predicted. Off: they are marked as static ones.
        pub tracking: bool = true;
        /// Paths may lead through passages in which the robot fits, but cannot turn on the spot. Off: every path has room for the
        /// circle around the robot.
        pub narrow_passages: bool = true;
        /// Paths are replanned. Off: the robot follows the first one to the end.
        pub replanning: bool = true;
        /// The robot can stop before a moving obstacle reaches it, even if that turns (passive safety). Off for a
        /// race among obstacles that ignore the robot, where standing does not help.
        pub passive_safety: bool = true;
        /// For passive safety, a pair of narrow objects counts as a person who stands, even if it was there all the time. Off
        /// where posts stand as close together as legs, and people do not.
        pub pairs_of_legs: bool = true;
        /// The lidar is compared with the map: the robot stands where it is blind, and keeps out of blind sectors.
        pub scan_health: bool = true;
        /// The robot slows down where a person may come out of a place that it cannot see, for what has just come out of one, and
        /// next to a narrow object that stands alone: it may be a person who starts to walk. Off among such posts without people.
        pub occlusion_speed: bool = true;
        /// With `pose_source = "scans"`, paths consider what the scans contradict in the map for a minute: an obstacle that appeared, or
        /// one that vanished. Off: the map stays as it is, and the changes are only reported. Switch it off where the map has
        /// walls that the lidar does not see, such as glass.
        pub map_changes: bool = true;
        /// The robot rotates in place towards its path, evades moving obstacles, and escapes where it is stuck.
        pub recovery: bool = true;
    }
}
