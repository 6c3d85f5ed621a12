//! How the navigator behaves, under the names that ROS users know where there is one.

use core::f64::consts::PI;

use serde::{Deserialize, Serialize};

use super::{Fault, NavigatorFeatures};
use crate::documented::documented;

documented! {
    /// Distances, tolerances and patience. The defaults drive the default robot through mine drifts.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct NavigatorSettings {
        /// The goal is reached when the robot stands within this distance of it, metres, above zero and at most 10000.
        pub xy_goal_tolerance: f64,
        /// Where the goal asks for a yaw, the robot must stand within this of it, radians, above zero and at most pi.
        pub yaw_goal_tolerance: f64,
        /// Within `xy_goal_tolerance` the robot parks: it tries to stand within this distance of the goal, metres, above
        /// zero and at most 10000.
        pub xy_parking_tolerance: f64,
        /// And within this of the yaw asked for, radians, above zero and at most pi.
        pub yaw_parking_tolerance: f64,
        /// A goal this near and straight ahead is driven at by distance alone, metres, 0 to 10000.
        pub parking_distance_m: f64,
        /// When this is over and it stands within the goal's tolerances, it has arrived all the same, seconds, 0 to 10000.
        pub parking_timeout_s: f64,
        /// How long it stands at each stop of a tour, seconds, 0 to 10000.
        pub waypoint_pause_s: f64,
        /// From a command to its effect, seconds, 0 to 10000: the robot's motion until then is taken for granted.
        pub actuation_delay_s: f64,
        /// Gap kept to everything beyond the footprint, metres, 0 to 10000, on top of the map's own coarseness.
        pub safety_margin_m: f64,
        /// Gap kept to moving obstacles, metres, 0 to 10000: they may turn round at any moment.
        pub moving_margin_m: f64,
        /// Gap kept to somebody who came within that margin, metres, 0 to 10000: enough to pass slowly.
        pub passing_margin_m: f64,
        /// Highest speed while something is within its margin, m/s, above zero and at most 10000.
        pub passing_speed: f64,
        /// Extra distance to walls that the global path keeps where there is room, metres, 0 to 10000.
        pub comfort_margin_m: f64,
        /// A path that keeps it is taken if it is at most this many times as long as one that does not, 1 to 10000.
        pub comfort_detour: f64,
        /// Key nodes are at most this far apart along the path, metres, 0.01 to 10000.
        pub key_node_spacing_m: f64,
        /// The local target is the first key node at least this far ahead along the path, metres, above zero and at most
        /// 10000, if it is in sight: as far as the robot gets within the horizon, or it would dawdle.
        pub lookahead_m: f64,
        /// And if not, one nearer that is, down to the first at least this far ahead, metres, 0 to 10000.
        pub min_lookahead_m: f64,
        /// The path is checked for new obstacles this far ahead, metres, 0 to 10000, as far as the local window shows.
        pub path_check_distance_m: f64,
        /// The robot turns in place when the target lies further off its heading than this, radians, above zero and at most
        /// pi.
        pub rotate_in_place_from: f64,
        /// It drives on when the target lies within this, radians, above zero and at most `rotate_in_place_from`.
        pub rotate_in_place_until: f64,
        /// It tries something else after standing or creeping for this long, seconds, 0 to 10000.
        pub stuck_patience_s: f64,
        /// Time from one attempt to plan anew to the next, seconds, 0 to 10000.
        pub replan_period_s: f64,
        /// Age of a scan, seconds, above zero and at most 10000, from which the robot stops: Nav2's
        /// `costmap_update_timeout`.
        pub scan_timeout_s: f64,
        /// It gives up when its senses could not be believed for so many seconds' worth of ticks, 0 to 10000.
        pub sensor_fault_patience_s: f64,
        /// The same of a robot whose localisation says that it is lost, 0 to 10000: it stands until it is found.
        pub localization_patience_s: f64,
        /// A new plan is followed so long after it was asked for, seconds, 0 to 10000; planning runs beside the control
        /// loop.
        pub planning_budget_s: f64,
        /// Whether to stop the control loop for a plan that takes longer than that. It keeps a simulated run the same at each
        /// repetition; a robot goes on and takes the plan when it is there.
        pub wait_for_plans: bool,
        /// What a decision may take, seconds, above zero and at most 10000, such as 0.05: one that takes longer is not
        /// sent. None: no decision is ever late, which keeps a simulated run the same at each repetition.
        pub deadline_s: Option<f64>,
        /// What has blocked the path for so long is taken to stay, however long the way round is, seconds, 0 to 10000.
        pub detour_patience_s: f64,
        /// A way found that is shorter than the rest of the path by this share is taken, 0 to 1, though nothing blocks the path.
        pub min_shortcut_share: f64,
        /// Progress along the path that counts as such, metres, above zero and at most 10000 (Nav2:
        /// `required_movement_radius`).
        pub required_movement_radius: f64,
        /// The mission is given up after this long without progress, seconds, above zero and at most 10000.
        pub movement_time_allowance: f64,
        /// Speed at which the robot backs out of a dead end, m/s, above zero and at most 10000.
        pub escape_speed: f64,
        /// What it does beyond the dynamic window.
        pub features: NavigatorFeatures,
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

impl NavigatorSettings {
    /// Checks every number.
    ///
    /// # Errors
    /// [`Fault::BadSetting`] names the first that is out of range.
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
