//! Settings of the protective layer, under the names of Nav2's `collision_monitor` where it has one.

use serde::{Deserialize, Serialize};

use super::polygon::Polygons;
use crate::settings::settings;

settings! {
    /// The protective layer below the planner: it limits each command by the raw scan. Names follow Nav2's
    /// `collision_monitor`.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct CollisionMonitorSettings {
        /// Whether the layer looks at scans. Arming and the operator's stop act in any case.
        pub enabled: bool = true;
        /// Distance that the body keeps to every return of the raw scan. Default 0.03 m: three times the noise of a small
        /// lidar.
        pub margin_m: f64 = 0.03, ["m", 0 to 1];
        /// Returns near to each other from which it acts. Default 2: single returns may be dust.
        pub min_points: usize = 2, ["", 1 to 1000];
        /// Time for which the robot can keep a command and then still stop before a collision. The layer reduces the
        /// command until this holds. Default 0.1 s, one period of the planner.
        pub time_before_collision: f64 = 0.1, ["s", 0 to 10];
        /// Step of the simulated motion.
        pub simulation_time_step: f64 = 0.05, ["s", 0.005 to 0.5];
        /// Time from a command to its effect until the layer has identified it. Default 0.3 s, as the navigator assumes.
        pub stopping_delay_s: f64 = 0.3, ["s", 0 to 5];
        /// Additional distance to the stopping motion within which a return reduces the speed to `linear_limit`.
        pub slow_margin_m: f64 = 0.05, ["m", 0 to 10];
        /// Highest speed of any point of the body in the slow zone.
        pub linear_limit: f64 = 0.5, ["m/s", above 0 to 100];
        /// Assumed speed of returns within the free space of an earlier scan. Default 1.6 m/s, the walking
        /// speed of ISO 13855; zero treats every return as standing.
        pub approach_speed_m_s: f64 = 1.6, ["m/s", 0 to 10];
        /// Highest speed of any point of the body while a return lies within it: only motion away from it is permitted.
        pub escape_speed: f64 = 0.1, ["m/s", above 0 to 10];
        /// Highest speed of any point of the body into a gap without any measurement, or of the body sideways into one beside its way
        /// ahead; zero forbids it. A gap below 50 degrees may be
        /// open space and is no such gap.
        pub blind_speed_limit: f64 = 0.1, ["m/s", 0 to 10];
        /// Share of beams with a return below which the whole scan is blind, and the robot stops. Zero permits scans
        /// without any return, as in the open.
        pub min_return_share: f64 = 0.02, ["", 0 to 1];
        /// Age of a scan, by its stamp, from which the robot stops.
        pub source_timeout: f64 = 0.3, ["s", above 0 to 10];
        /// Number of consecutive scans with identical ranges from which the lidar counts as frozen if the base moves. Scans with
        /// fewer than 10 equal returns do not count: in the open every scan is empty.
        pub frozen_scans: usize = 3, ["", 2 to 1000];
        /// Fixed zones in the robot's frame, as in Nav2; none by default. Each is a table with the keys `name`,
        /// `action_type` (`stop`, `slowdown`, `limit` or `approach`), `points` (at least three pairs, metres), and
        /// optionally `min_points`, `slowdown_ratio`, `linear_limit`, `angular_limit`, `time_before_collision`, `enabled`.
        pub polygons: Polygons = Polygons::default();
    }
}
