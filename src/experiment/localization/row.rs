//! The row of one drive.

use serde::Serialize;

use crate::bench::columns::columns;

columns! {
    /// One drive.
    #[derive(Clone, Debug, Default, PartialEq, Serialize)]
    pub struct LocalizationRow {
        /// Name of the case.
        pub case: String,
        /// Name of the map.
        pub map: String,
        /// Seed of all noise.
        pub seed: u64,
        /// Share of each track's speed that is lost to slip.
        pub slip: f64,
        /// Whether the robot reached the last stop.
        pub reached: bool,
        /// Whether the robot touched anything.
        pub collided: bool,
        /// Distance driven, metres.
        pub travelled_m: f64 => 1,
        /// Time, seconds.
        pub time_s: f64 => 1,
        /// Largest position error over all ticks at which the robot was not lost, metres; the first second after an injected
        /// fault does not count.
        pub worst_m: f64 => 4,
        /// The same of the yaw, radians.
        pub worst_rad: f64 => 4,
        /// Largest position error over the ticks at which it was neither lost nor uncertain, metres.
        pub worst_tracking_m: f64 => 4,
        /// Root mean square of the position errors, metres.
        pub rms_m: f64 => 4,
        /// Largest error of odometry alone over the same ticks, metres.
        pub odometry_worst_m: f64 => 2,
        /// The same of the yaw, radians.
        pub odometry_worst_rad: f64 => 4,
        /// Largest standard deviation that the robot reported for its position, metres.
        pub sigma_m: f64 => 3,
        /// Share of revolutions in which scans did not observe at least one direction.
        pub unseen_share: f64 => 3,
        /// Smallest share of beams that agree with the map.
        pub least_agreement: f64 => 3,
        /// Number of ticks at which the robot was uncertain.
        pub uncertain_ticks: u64,
        /// Number of ticks at which it was lost.
        pub lost_ticks: u64,
        /// Why it was first lost.
        pub lost_reason: Option<String>,
        /// Time from the fault, or from the start without one, until the robot was lost, seconds.
        pub lost_after_s: Option<f64> => 1,
        /// Distance driven from the fault until it stood or was localized again, metres.
        pub driven_on_m: Option<f64> => 1,
        /// Time from being lost until it was localized again, seconds.
        pub found_after_s: Option<f64> => 1,
        /// Why the navigator gave up, if it did.
        pub fault: Option<String>,
        /// Digest of the trace.
        pub trace_digest: String,
    }
}
