//! Settings of the navigator, under Nav2's names where Nav2 has one.

use core::f64::consts::PI;

use serde::{Deserialize, Serialize};

use super::Fault;
use crate::documented::documented;

documented! {
    /// Distances, tolerances and times of the navigator. The defaults drive the default robot through mine roadways.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    #[non_exhaustive]
    pub struct NavigatorSettings {
        /// The goal is reached when the robot stands within this distance of it, metres, above zero and at most 10000.
        pub xy_goal_tolerance: f64,
        /// Where the goal has a yaw, the robot must stand within this of it, radians, above zero and at most pi.
        pub yaw_goal_tolerance: f64,
        /// Within `xy_goal_tolerance` the robot parks: it tries to stand within this distance of the goal, metres, above
        /// zero and at most 10000.
        pub xy_parking_tolerance: f64,
        /// Parking tries to stand within this of the goal's yaw, radians, above zero and at most pi.
        pub yaw_parking_tolerance: f64,
        /// The robot parks straight at a goal ahead that is nearer than this, metres, 0 to 10000.
        pub parking_distance_m: f64,
        /// After this time a parking robot has arrived if it stands within the goal's tolerances, seconds, 0 to 10000.
        pub parking_timeout_s: f64,
        /// Pause at each waypoint, seconds, 0 to 10000.
        pub waypoint_pause_s: f64,
        /// Time from a command to its effect, seconds, 0 to 10000. The navigator predicts the robot's motion until then.
        pub actuation_delay_s: f64,
        /// Distance that the robot keeps to static obstacles, metres, 0 to 10000, on top of the margin for the map's resolution.
        pub safety_margin_m: f64,
        /// Distance that the robot keeps to moving obstacles, metres, 0 to 10000: they may turn at any moment.
        pub moving_margin_m: f64,
        /// Distance that the robot keeps to an obstacle that came within that margin, metres, 0 to 10000: enough to pass slowly.
        pub passing_margin_m: f64,
        /// Highest speed while an obstacle is within its margin, m/s, above zero and at most 10000.
        pub passing_speed: f64,
        /// Additional distance to walls that the global path keeps where there is room, metres, 0 to 10000.
        pub comfort_margin_m: f64,
        /// A path that keeps it may be at most this many times as long as one that does not, 1 to 10000.
        pub comfort_detour: f64,
        /// Largest distance between two key nodes along the path, metres, 0.01 to 10000.
        pub key_node_spacing_m: f64,
        /// The local target is the first key node at least this far ahead along the path, metres, above zero and at most
        /// 10000, if it is in sight. With less than the distance driven within the horizon the robot drives slowly.
        pub lookahead_m: f64,
        /// Where that key node is not in sight, a nearer one is, at least this far ahead, metres, 0 to 10000.
        pub min_lookahead_m: f64,
        /// The path is checked for new obstacles this far ahead, metres, 0 to 10000, as far as the local window shows.
        pub path_check_distance_m: f64,
        /// The robot rotates in place when the target lies further off its heading than this, radians, above zero and at
        /// most pi.
        pub rotate_in_place_from: f64,
        /// The rotation ends when the target lies within this of the heading, radians, above zero and at most
        /// `rotate_in_place_from`.
        pub rotate_in_place_until: f64,
        /// The robot escapes after it has stood or crept for this long, seconds, 0 to 10000.
        pub stuck_patience_s: f64,
        /// Shortest time between two requests for a plan, seconds, 0 to 10000.
        pub replan_period_s: f64,
        /// Age of a scan, seconds, above zero and at most 10000, from which the robot brakes: Nav2's
        /// `costmap_update_timeout`.
        pub scan_timeout_s: f64,
        /// The mission fails after faulty observations for this long, seconds, 0 to 10000.
        pub sensor_fault_patience_s: f64,
        /// The mission fails after the localisation has not known the pose for this long, seconds, 0 to 10000; the robot
        /// stands meanwhile.
        pub localization_patience_s: f64,
        /// Time from the request for a plan until the robot follows it, seconds, 0 to 10000; planning runs on its own thread.
        pub planning_budget_s: f64,
        /// Whether the control loop waits for a plan that takes longer than that. A simulated run is then the same at each
        /// repetition. A real robot goes on and takes the plan when it is ready.
        pub wait_for_plans: bool,
        /// Longest duration of a decision, seconds, above zero and at most 10000, such as 0.05; a later decision is not
        /// sent. Without a value no decision is late, and a simulated run is the same at each repetition.
        pub deadline_s: Option<f64>,
        /// An obstacle that has blocked the path for this long is taken to stay, however long the detour is, seconds, 0 to
        /// 10000.
        pub detour_patience_s: f64,
        /// The robot takes a shortcut that saves at least this share of the remaining path, 0 to 1.
        pub min_shortcut_share: f64,
        /// Shortest advance along the path that counts as progress, metres, above zero and at most 10000 (Nav2:
        /// `required_movement_radius`).
        pub required_movement_radius: f64,
        /// The mission fails after this long without progress, seconds, above zero and at most 10000 (Nav2:
        /// `movement_time_allowance`).
        pub movement_time_allowance: f64,
        /// Speed at which the robot escapes, m/s, above zero and at most 10000.
        pub escape_speed: f64,
        /// Features beyond the dynamic window.
        pub features: NavigatorFeatures,
    }
}

documented! {
    /// What the navigator does beyond the dynamic window. All is on by default; without a feature an experiment shows what it
    /// gains.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    #[non_exhaustive]
    pub struct NavigatorFeatures {
        /// The robot follows a global path. Off: the goal itself is the local target.
        pub global_path: bool,
        /// The robot passes key nodes, half a metre apart, by progress along the path. Off: the local targets are the nodes of
        /// the pruned path, and the robot must touch each before the next, as in the paper (section 3.3.3, step 4).
        pub progress: bool,
        /// Moving obstacles are tracked and predicted. Off: they are marked as static ones.
        pub tracking: bool,
        /// Paths are replanned. Off: the robot follows the first one to the end.
        pub replanning: bool,
        /// The robot can stop before a moving obstacle reaches it, even if that turns (passive safety). Off for a race among
        /// obstacles that ignore the robot, where standing does not help.
        pub passive_safety: bool,
        /// The robot rotates in place towards its path, evades moving obstacles, and escapes where it is stuck.
        pub recovery: bool,
    }
}

impl Default for NavigatorSettings {
    fn default() -> Self {
        Self {
            xy_goal_tolerance: 0.25,
            yaw_goal_tolerance: 0.1,
            xy_parking_tolerance: 0.006,
            yaw_parking_tolerance: 0.003,
            parking_distance_m: 1.0,
            parking_timeout_s: 30.0,
            waypoint_pause_s: 5.0,
            actuation_delay_s: 0.08,
            safety_margin_m: 0.05,
            moving_margin_m: 0.35,
            passing_margin_m: 0.15,
            passing_speed: 0.3,
            comfort_margin_m: 0.25,
            comfort_detour: 1.5,
            key_node_spacing_m: 0.5,
            lookahead_m: 3.0,
            min_lookahead_m: 1.0,
            path_check_distance_m: 8.0,
            rotate_in_place_from: 1.2,
            rotate_in_place_until: 0.3,
            stuck_patience_s: 3.0,
            replan_period_s: 0.5,
            scan_timeout_s: 0.3,
            sensor_fault_patience_s: 3.0,
            localization_patience_s: 30.0,
            planning_budget_s: 0.1,
            wait_for_plans: true,
            deadline_s: None,
            detour_patience_s: 10.0,
            min_shortcut_share: 0.1,
            required_movement_radius: 0.5,
            movement_time_allowance: 90.0,
            escape_speed: 0.25,
            features: NavigatorFeatures::default(),
        }
    }
}

impl Default for NavigatorFeatures {
    fn default() -> Self {
        Self {
            global_path: true,
            progress: true,
            tracking: true,
            replanning: true,
            passive_safety: true,
            recovery: true,
        }
    }
}

impl NavigatorSettings {
    /// Checks the range of every number.
    ///
    /// # Errors
    /// [`Fault::BadSetting`] with the first one out of range.
    pub fn validate(&self) -> Result<(), Fault> {
        let above_zero = "above zero and at most 10000";
        let at_least_zero = "0 to 10000";
        for (name, value, expected) in [
            ("xy_goal_tolerance", self.xy_goal_tolerance, above_zero),
            (
                "xy_parking_tolerance",
                self.xy_parking_tolerance,
                above_zero,
            ),
            ("parking_timeout_s", self.parking_timeout_s, at_least_zero),
            ("waypoint_pause_s", self.waypoint_pause_s, at_least_zero),
            ("parking_distance_m", self.parking_distance_m, at_least_zero),
            ("detour_patience_s", self.detour_patience_s, at_least_zero),
            ("actuation_delay_s", self.actuation_delay_s, at_least_zero),
            ("planning_budget_s", self.planning_budget_s, at_least_zero),
            ("safety_margin_m", self.safety_margin_m, at_least_zero),
            ("moving_margin_m", self.moving_margin_m, at_least_zero),
            ("passing_margin_m", self.passing_margin_m, at_least_zero),
            ("passing_speed", self.passing_speed, above_zero),
            ("comfort_margin_m", self.comfort_margin_m, at_least_zero),
            ("lookahead_m", self.lookahead_m, above_zero),
            ("min_lookahead_m", self.min_lookahead_m, at_least_zero),
            (
                "path_check_distance_m",
                self.path_check_distance_m,
                at_least_zero,
            ),
            ("stuck_patience_s", self.stuck_patience_s, at_least_zero),
            ("replan_period_s", self.replan_period_s, at_least_zero),
            ("scan_timeout_s", self.scan_timeout_s, above_zero),
            (
                "sensor_fault_patience_s",
                self.sensor_fault_patience_s,
                at_least_zero,
            ),
            (
                "localization_patience_s",
                self.localization_patience_s,
                at_least_zero,
            ),
            (
                "required_movement_radius",
                self.required_movement_radius,
                above_zero,
            ),
            (
                "movement_time_allowance",
                self.movement_time_allowance,
                above_zero,
            ),
            ("escape_speed", self.escape_speed, above_zero),
        ] {
            let least = if expected == above_zero {
                f64::MIN_POSITIVE
            } else {
                0.0
            };
            within(name, value, least, 10_000.0, expected)?;
        }
        within(
            "comfort_detour",
            self.comfort_detour,
            1.0,
            10_000.0,
            "1 to 10000",
        )?;
        within(
            "key_node_spacing_m",
            self.key_node_spacing_m,
            0.01,
            10_000.0,
            "0.01 to 10000",
        )?;
        for (name, value) in [
            ("yaw_goal_tolerance", self.yaw_goal_tolerance),
            ("yaw_parking_tolerance", self.yaw_parking_tolerance),
            ("rotate_in_place_from", self.rotate_in_place_from),
        ] {
            within(
                name,
                value,
                f64::MIN_POSITIVE,
                PI,
                "above zero and at most pi",
            )?;
        }
        if let Some(deadline_s) = self.deadline_s {
            within(
                "deadline_s",
                deadline_s,
                f64::MIN_POSITIVE,
                10_000.0,
                above_zero,
            )?;
        }
        within(
            "min_shortcut_share",
            self.min_shortcut_share,
            0.0,
            1.0,
            "0 to 1",
        )?;
        let until = self.rotate_in_place_until;
        let expected = "above zero and at most rotate_in_place_from";
        within(
            "rotate_in_place_until",
            until,
            f64::MIN_POSITIVE,
            self.rotate_in_place_from,
            expected,
        )
    }
}

fn within(
    name: &'static str,
    value: f64,
    least: f64,
    most: f64,
    expected: &'static str,
) -> Result<(), Fault> {
    if (least..=most).contains(&value) {
        return Ok(());
    }
    Err(Fault::BadSetting {
        name,
        value,
        expected,
    })
}
