//! Localisation on a map by odometry and lidar scans, with detection of a lost pose.
//!
//! Odometry is smooth but drifts by track slip. Each lidar revolution is matched to the map: Gauss-Newton minimisation of the
//! signed distances between beam ends and mapped surfaces, with robust weights for unmapped objects and the odometry
//! estimate as prior. Directions that the map does not constrain, as along a straight and smooth roadway, follow odometry
//! alone, and the estimate's covariance grows accordingly.
//!
//! The same beams check the pose: they must end on mapped surfaces, and none may pass through one. A lost localizer reports
//! the reason. It searches the whole map and relocalises only if one place matches better than all others. Several consecutive
//! scans must confirm the result, and so must the first metre of the drive afterwards. A robot that moves by its odometry
//! but not by its scans is stuck, or its lidar is frozen. The localizer reports this. After the third time at the same place it
//! stops relocalising.
//!
//! Results are identical on every machine: sums run in the order of the beams, and trigonometry uses `libm`.

mod agreement;
mod change_detector;
mod coarse_search;
mod deskewed_scan;
mod free_places;
mod frontier;
mod localizer;
mod map_changes;
mod map_scores;
mod motion_check;
mod mount_check;
mod narrow_objects;
mod pose_estimate;
mod pose_filters;
mod pose_hint;
mod relocalization;
mod scan_matcher;
mod score_pyramid;
mod settings;
mod signed_distance_field;

pub use agreement::Agreement;
#[cfg(feature = "logs")]
pub(crate) use coarse_search::{CellScores, coarse_search};
pub use deskewed_scan::{DeskewedScan, Hit, PoseHistory, Ray};
pub use localizer::Localizer;
pub use map_changes::{ChangedArea, MapChanges};
pub use pose_estimate::{LocalizationStatus, LostReason, PoseEstimate};
pub use pose_filters::{PoseFilter, PoseMeasurement};
pub use pose_hint::PoseHint;
#[cfg(feature = "logs")]
pub(crate) use scan_matcher::{ScanMatcher, Surfaces, information_of};
#[cfg(feature = "logs")]
pub(crate) use score_pyramid::{EndCells, ScorePyramid};
pub use settings::LocalizationSettings;
#[cfg(feature = "logs")]
pub(crate) use signed_distance_field::DistanceSample;
#[cfg(feature = "sim")]
pub(crate) use signed_distance_field::SignedDistanceField;

/// An invalid setting or start pose.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LocalizationError {
    /// A setting is out of range.
    #[error(transparent)]
    Setting(#[from] crate::settings::SettingError),
    /// The start pose is not finite.
    #[error("the start is ({x}, {y}, {yaw}): all three must be finite")]
    BadStart {
        /// The x coordinate found, metres.
        x: f64,
        /// The y coordinate found, metres.
        y: f64,
        /// The yaw found, radians.
        yaw: f64,
    },
}
