//! How much is believed, and when a robot counts as lost.

use serde::{Deserialize, Serialize};

use super::LocalizationError;
use crate::documented::documented;

documented! {
    /// Localisation by matching scans to the map.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct LocalizationSettings {
        /// How well the start is known along each axis, one standard deviation, metres, above zero and at most 10.
        pub initial_sigma_m: f64,
        /// How well its yaw is known, one standard deviation, radians, above zero and at most 1.
        pub initial_sigma_rad: f64,
        /// How far odometry's way may be off as a whole, one standard deviation, as a share, 0 to 0.5: the slip of tracks. It is
        /// learned on the way.
        pub distance_scale_sigma: f64,
        /// The same of odometry's turns, 0 to 0.5.
        pub turn_scale_sigma: f64,
        /// How far odometry's way may be off after one metre beyond that, one standard deviation, metres, above zero and at most 1.
        pub distance_sigma_m: f64,
        /// How far a beam that ends on a wall may end from the map's wall, one standard deviation, metres, above zero and at most 1:
        /// the lidar's noise and the map's.
        pub beam_sigma_m: f64,
        /// So many beams of a revolution count as independent witnesses, 1 to 10000: what is wrong with a map is wrong for all
        /// beams on the same wall.
        pub independent_beams: f64,
        /// A beam that ends farther from a wall than this, metres, above zero and at most 1, and half a cell tells nothing of the
        /// pose: somebody, or something that the map does not show.
        pub outlier_distance_m: f64,
        /// A direction along which fewer than this share of the beams would notice a motion is left to odometry, 0 to 1.
        pub min_information: f64,
        /// Fewer returns than this in a revolution are too few where the map shows walls, 1 to 10000.
        pub min_returns: usize,
        /// Less than this share of the beams in agreement with the map speaks against the pose, 0 to 1.
        pub min_agreement: f64,
        /// More than this share of the beams through walls of the map speaks against the pose, 0 to 1.
        pub max_through_walls: f64,
        /// So many revolutions that speak against the pose, each that does not taken off, make the robot lost, 1 to 1000.
        pub lost_after_scans: u32,
        /// A position that may be off by more than this, one standard deviation along the worse axis, metres, is uncertain, above zero
        /// and at most 100.
        pub uncertain_sigma_m: f64,
        /// The same of the yaw, radians, above zero and at most 3.
        pub uncertain_sigma_rad: f64,
        /// A position that may be off by more than this makes the robot lost, metres, above zero and at most 100.
        pub lost_sigma_m: f64,
        /// The same of the yaw, radians, above zero and at most 3.
        pub lost_sigma_rad: f64,
        /// This share of the beams must agree with the map for a lost robot to be found, 0 to 1.
        pub relocalized_agreement: f64,
        /// In so many revolutions in a row, 1 to 1000.
        pub relocalized_after_scans: u32,
        /// A lost robot is looked for within this distance of where odometry has it, metres, 0 to 20.
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
    /// Checks every number.
    ///
    /// # Errors
    /// [`LocalizationError::BadSetting`] names the first that is out of range.
    pub fn validate(&self) -> Result<(), LocalizationError> {
        let within = |least: f64, most: f64, expected, all: &[(&'static str, f64)]| {
            let bad = all
                .iter()
                .find(|(_, value)| !(least..=most).contains(value));
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
