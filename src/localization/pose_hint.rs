//! A rough pose from an operator or another system.

use super::LocalizationError;
use super::relocalization::SearchRegion;
use crate::geometry::Pose;
use crate::settings::require;

/// The robot is searched within this many standard deviations of a hint, and at least within this radius, metres, and this
/// angle, radians: a search has steps.
const SIGMAS: f64 = 3.0;
const MIN_RADIUS_M: f64 = 0.3;
const MIN_HALF_ANGLE_RAD: f64 = 0.2;

/// A rough pose in the map frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseHint {
    /// The pose.
    pub pose: Pose,
    /// Standard deviation of the position along any axis, metres, above 0 to 1000.
    pub sigma_m: f64,
    /// Standard deviation of the yaw, radians, above 0 to 1000: with more than one radian, any yaw.
    pub sigma_rad: f64,
}

impl PoseHint {
    /// Checks the numbers.
    ///
    /// # Errors
    /// When the pose is not finite or a standard deviation is out of range.
    pub fn validate(&self) -> Result<(), LocalizationError> {
        self.region().map(|_| ())
    }

    /// The region to search, in the map frame.
    pub(super) fn region(&self) -> Result<SearchRegion, LocalizationError> {
        let Self { pose, sigma_m, sigma_rad } = *self;
        if !pose.is_finite() {
            let Pose { x, y, yaw } = pose;
            return Err(LocalizationError::BadStart { x, y, yaw });
        }
        for (name, sigma) in [("sigma_m", sigma_m), ("sigma_rad", sigma_rad)] {
            require(sigma > 0.0 && sigma <= 1000.0, name, sigma, "above 0 to 1000")?;
        }
        Ok(SearchRegion {
            center: pose,
            radius_m: (SIGMAS * sigma_m).max(MIN_RADIUS_M),
            half_angle_rad: (SIGMAS * sigma_rad).max(MIN_HALF_ANGLE_RAD),
        })
    }
}
