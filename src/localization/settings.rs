//! Settings of the localiser.

use serde::{Deserialize, Serialize};

use super::LocalizationError;
use crate::documented::documented;

documented! {
    /// Localisation by scan matching.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct LocalizationSettings {
        /// Standard deviation of the start position along each axis, metres, above zero and at most 10.
        pub initial_sigma_m: f64,
        /// Standard deviation of the start yaw, radians, above zero and at most 1.
        pub initial_sigma_rad: f64,
        /// Standard deviation of the scale error of odometry's distances, 0 to 0.5: track slip. The scale is learned while
        /// driving.
        pub distance_scale_sigma: f64,
        /// Standard deviation of the scale error of odometry's turns, 0 to 0.5. The scale is learned while driving.
        pub turn_scale_sigma: f64,
        /// Standard deviation of the remaining odometry error after one metre, metres, above zero and at most 1.
        pub distance_sigma_m: f64,
        /// Standard deviation of a beam end from the mapped surface, metres, above zero and at most 1: noise of lidar and map.
        pub beam_sigma_m: f64,
        /// Number of beams of a revolution that count as independent, 1 to 10000. A map error affects all beams on the same
        /// surface.
        pub independent_beams: f64,
        /// Beams that end farther from a surface than this plus half a cell, metres, are ignored as unmapped objects; above
        /// zero and at most 1.
        pub outlier_distance_m: f64,
        /// A direction of motion to which less than this fraction of the beams is sensitive follows odometry alone, 0 to 1.
        pub min_information: f64,
        /// A revolution with fewer returns than this is rejected where the map shows surfaces, 1 to 10000.
        pub min_returns: usize,
        /// A revolution is rejected if less than this fraction of its beams agrees with the map, 0 to 1.
        pub min_agreement: f64,
        /// A revolution is rejected if more than this fraction of its beams passes through mapped obstacles, 0 to 1.
        pub max_through_walls: f64,
        /// Localisation is lost when rejected revolutions outnumber accepted ones by this many, 1 to 1000.
        pub lost_after_scans: u32,
        /// The pose is uncertain above this standard deviation along the worse axis, metres, above zero and at most 100.
        pub uncertain_sigma_m: f64,
        /// The pose is uncertain above this standard deviation of the yaw, radians, above zero and at most 3.
        pub uncertain_sigma_rad: f64,
        /// Localisation is lost above this standard deviation along the worse axis, metres, above zero and at most 100.
        pub lost_sigma_m: f64,
        /// Localisation is lost above this standard deviation of the yaw, radians, above zero and at most 3.
        pub lost_sigma_rad: f64,
        /// Fraction of the beams that must agree with the map to relocalise, 0 to 1.
        pub relocalized_agreement: f64,
        /// Number of consecutive revolutions that must confirm a relocalised pose, 1 to 1000.
        pub relocalized_after_scans: u32,
        /// Search radius of relocalisation around the last pose, metres, 0 to 20.
        pub relocalization_radius_m: f64,
    }
}

impl Default for LocalizationSettings {
    fn default() -> Self {
        Self {
            initial_sigma_m: 0.1,
            initial_sigma_rad: 0.05,
            distance_scale_sigma: 0.05,
            turn_scale_sigma: 0.03,
            distance_sigma_m: 0.04,
            beam_sigma_m: 0.03,
            independent_beams: 60.0,
            outlier_distance_m: 0.12,
            min_information: 0.01,
            min_returns: 30,
            min_agreement: 0.5,
            max_through_walls: 0.25,
            lost_after_scans: 5,
            uncertain_sigma_m: 0.025,
            uncertain_sigma_rad: 0.01,
            lost_sigma_m: 0.5,
            lost_sigma_rad: 0.15,
            relocalized_agreement: 0.7,
            relocalized_after_scans: 5,
            relocalization_radius_m: 3.0,
        }
    }
}

impl LocalizationSettings {
    /// Validates all settings.
    ///
    /// # Errors
    /// [`LocalizationError::BadSetting`] names the first setting that is out of range.
    pub fn validate(&self) -> Result<(), LocalizationError> {
        let within = |min: f64, max: f64, expected, values: &[(&'static str, f64)]| {
            let bad = values
                .iter()
                .find(|(_, value)| !(min..=max).contains(value));
            bad.map_or(Ok(()), |&(name, value)| {
                Err(LocalizationError::BadSetting {
                    name,
                    value,
                    expected,
                })
            })
        };
        let above_zero = f64::MIN_POSITIVE;
        let tens = [("initial_sigma_m", self.initial_sigma_m)];
        within(above_zero, 10.0, "above zero and at most 10", &tens)?;
        let ones = [
            ("initial_sigma_rad", self.initial_sigma_rad),
            ("distance_sigma_m", self.distance_sigma_m),
            ("beam_sigma_m", self.beam_sigma_m),
            ("outlier_distance_m", self.outlier_distance_m),
        ];
        within(above_zero, 1.0, "above zero and at most 1", &ones)?;
        let scales = [
            ("distance_scale_sigma", self.distance_scale_sigma),
            ("turn_scale_sigma", self.turn_scale_sigma),
        ];
        within(0.0, 0.5, "0 to 0.5", &scales)?;
        let shares = [
            ("min_information", self.min_information),
            ("min_agreement", self.min_agreement),
            ("max_through_walls", self.max_through_walls),
            ("relocalized_agreement", self.relocalized_agreement),
        ];
        within(0.0, 1.0, "0 to 1", &shares)?;
        let positions = [
            ("uncertain_sigma_m", self.uncertain_sigma_m),
            ("lost_sigma_m", self.lost_sigma_m),
        ];
        within(above_zero, 100.0, "above zero and at most 100", &positions)?;
        let yaws = [
            ("uncertain_sigma_rad", self.uncertain_sigma_rad),
            ("lost_sigma_rad", self.lost_sigma_rad),
        ];
        within(above_zero, 3.0, "above zero and at most 3", &yaws)?;
        let beams = [
            ("independent_beams", self.independent_beams),
            ("min_returns", self.min_returns as f64),
        ];
        within(1.0, 1e4, "1 to 10000", &beams)?;
        let turns = [
            ("lost_after_scans", f64::from(self.lost_after_scans)),
            (
                "relocalized_after_scans",
                f64::from(self.relocalized_after_scans),
            ),
        ];
        within(1.0, 1e3, "1 to 1000", &turns)?;
        let search = [("relocalization_radius_m", self.relocalization_radius_m)];
        within(0.0, 20.0, "0 to 20", &search)
    }
}
