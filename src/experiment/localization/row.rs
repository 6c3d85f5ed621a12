//! What came of a drive by matched scans.

use serde::Serialize;

use crate::bench::Columns;

/// One drive.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LocalizationRow {
    /// What it was to show.
    pub case: String,
    /// Name of the map.
    pub map: String,
    /// Seed of all noise.
    pub seed: u64,
    /// Share of each belt's speed that the ground took.
    pub slip: f64,
    /// Whether the last stop was reached.
    pub reached: bool,
    /// Whether anything was touched.
    pub collided: bool,
    /// Way driven, metres.
    pub travelled_m: f64,
    /// Time, seconds.
    pub time_s: f64,
    /// Worst error of the position over all ticks at which the robot did not say that it was lost, metres; not over the first second
    /// after a mishap.
    pub worst_m: f64,
    /// The same of the yaw, radians.
    pub worst_rad: f64,
    /// Worst error of the position over the ticks at which it was neither lost nor uncertain, metres.
    pub worst_tracking_m: f64,
    /// Root mean square of the errors of position, metres.
    pub rms_m: f64,
    /// Worst error of odometry alone over the same ticks, metres.
    pub odometry_worst_m: f64,
    /// The same of the yaw, radians.
    pub odometry_worst_rad: f64,
    /// Most that the robot said its position might be off, one standard deviation, metres.
    pub sigma_m: f64,
    /// Revolutions that left at least one direction to odometry, as a share.
    pub unseen_share: f64,
    /// Least share of beams in agreement with the map.
    pub least_agreement: f64,
    /// Ticks at which the robot said that it was uncertain.
    pub uncertain_ticks: u64,
    /// Ticks at which it said that it was lost.
    pub lost_ticks: u64,
    /// Why it first was.
    pub lost_why: Option<String>,
    /// From the mishap, or the start where there was none, until it said so, seconds.
    pub lost_after_s: Option<f64>,
    /// From the mishap until it stood or was found, way driven, metres.
    pub driven_on_m: Option<f64>,
    /// From saying so until it was found again, seconds.
    pub found_after_s: Option<f64>,
    /// Why the mission was given up, if it was.
    pub fault: Option<String>,
    /// Digest of the trace.
    pub trace_digest: String,
}

impl Columns for LocalizationRow {
    const COLUMNS: &[&str] = &[
        "case",
        "map",
        "seed",
        "slip",
        "reached",
        "collided",
        "travelled_m",
        "time_s",
        "worst_m",
        "worst_rad",
        "worst_tracking_m",
        "rms_m",
        "odometry_worst_m",
        "odometry_worst_rad",
        "sigma_m",
        "unseen_share",
        "least_agreement",
        "uncertain_ticks",
        "lost_ticks",
        "lost_why",
        "lost_after_s",
        "driven_on_m",
        "found_after_s",
        "fault",
        "trace_digest",
    ];
}
