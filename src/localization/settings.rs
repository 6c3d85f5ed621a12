//! Settings of the localizer.

use serde::{Deserialize, Serialize};

use crate::settings::settings;

settings! {
    /// Localisation by scan matching.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct LocalizationSettings {
        /// Standard deviation of the start position along each axis.
        pub initial_sigma_m: f64 = 0.1, ["m", above 0 to 10];
        /// Standard deviation of the start yaw.
        pub initial_sigma_rad: f64 = 0.05, ["rad", above 0 to 1];
        /// Standard deviation of the scale error of odometry's distances: track slip. The scale is learned while
        /// driving.
        pub distance_scale_sigma: f64 = 0.05, ["", 0 to 0.5];
        /// Standard deviation of the scale error of odometry's turns. The scale is learned while driving. By encoders on
        /// tracks with an uncalibrated width, turns are off by a third.
        pub turn_scale_sigma: f64 = 0.15, ["", 0 to 0.5];
        /// Standard deviation of the remaining odometry error after one metre.
        pub distance_sigma_m: f64 = 0.04, ["m", above 0 to 1];
        /// Standard deviation of a beam end from the mapped surface: noise of lidar and map.
        pub beam_sigma_m: f64 = 0.03, ["m", above 0 to 1];
        /// Number of beams of a revolution that count as independent. A map error affects all beams on the same
        /// surface.
        pub independent_beams: f64 = 60.0, ["", 1 to 10000];
        /// Beams that end farther from a surface than this plus half a cell are ignored as unmapped objects.
        pub outlier_distance_m: f64 = 0.12, ["m", above 0 to 1];
        /// A direction of motion to which less than this fraction of the beams is sensitive follows odometry alone.
        pub min_information: f64 = 0.01, ["", 0 to 1];
        /// A revolution with fewer returns than this is rejected where the map shows surfaces.
        pub min_returns: usize = 30, ["", 1 to 10000];
        /// A revolution is rejected if less than this fraction of its beams agrees with the map.
        pub min_agreement: f64 = 0.5, ["", 0 to 1];
        /// A revolution is rejected if more than this fraction of its beams passes through mapped obstacles, and more than half as
        /// many as agree with the map.
        pub max_through_walls: f64 = 0.25, ["", 0 to 1];
        /// Localisation is lost when rejected revolutions outnumber accepted ones by this many.
        pub lost_after_scans: u32 = 5, ["", 1 to 1000];
        /// The pose is uncertain above this standard deviation along the worse axis.
        pub uncertain_sigma_m: f64 = 0.025, ["m", above 0 to 100];
        /// The pose is uncertain above this standard deviation of the yaw.
        pub uncertain_sigma_rad: f64 = 0.01, ["rad", above 0 to 3];
        /// Localisation is lost above this standard deviation along the worse axis.
        pub lost_sigma_m: f64 = 0.5, ["m", above 0 to 100];
        /// The same along the one direction of motion that the scans do not show, as along a smooth roadway; at least
        /// `lost_sigma_m` counts.
        pub lost_sigma_along_m: f64 = 1.0, ["m", above 0 to 100];
        /// Localisation is lost above this standard deviation of the yaw.
        pub lost_sigma_rad: f64 = 0.15, ["rad", above 0 to 3];
        /// Fraction of the beams that must agree with the map to relocalise.
        pub relocalized_agreement: f64 = 0.75, ["", 0 to 1];
        /// A larger fraction of the beams must agree at a relocalised pose than at any other place of the map, by this.
        pub relocalization_margin: f64 = 0.12, ["", 0 to 1];
        /// Number of consecutive revolutions that must confirm a relocalised pose.
        pub relocalized_after_scans: u32 = 5, ["", 1 to 1000];
    }
}
