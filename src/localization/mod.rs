//! Where am I: wheel odometry held to the map by what the lidar sees, and an honest word when it is lost.
//!
//! Odometry is smooth and drifts by the slip of the tracks. Each revolution of the lidar is laid on the map: the pose is moved
//! until the beams end on the map's walls (Gauss and Newton's method on the signed distance to the walls, with weights that
//! leave out what the map does not show), held by what odometry says and how well. Where the walls do not tell the pose along a
//! direction, as in a straight and smooth roadway, that direction is left to odometry, and the fix says how far it may be off.
//!
//! Whether the robot is where it believes to be is judged by the same beams: do they end on walls, and do they reach their ends
//! without passing through one? A robot that is lost says so, with the reason, and counts as found only when scan after scan
//! agrees with the map again.
//!
//! The same calls give the same bits on every machine: sums run in the order of the beams, and trigonometry is `libm`'s.

mod agreement;
mod deskewed_scan;
mod error;
mod localizer;
mod pose_ekf;
mod pose_estimate;
mod pose_history;
mod relocalization;
mod scan_matcher;
mod settings;
mod signed_distance_field;

pub use agreement::Agreement;
pub use deskewed_scan::DeskewedScan;
pub use error::LocalizationError;
pub use localizer::Localizer;
pub use pose_estimate::{LocalizationStatus, LostReason, PoseEstimate};
pub use pose_history::PoseHistory;
pub use settings::LocalizationSettings;
