//! Description of the robot: footprint, limits, tracked drive and encoders.

use thiserror::Error;

use crate::settings::SettingError;

mod encoder;
mod footprint;
mod kinematics;
mod limits;
mod mixer;
mod per_track;
mod track_limits;

pub use encoder::{TrackOdometry, travel_m};
pub use footprint::{Disc, Footprint};
pub use kinematics::{TrackSpeeds, TrackedDrive};
pub use limits::Limits;
pub use mixer::Mixer;
pub use per_track::{PerTrack, Side};
pub use track_limits::TrackLimits;

/// An invalid robot description.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum RobotError {
    /// A footprint without discs.
    #[error(
        "the footprint has no disc: give at least one, such as {{x = 0.0, y = 0.0, radius = 0.3}}"
    )]
    EmptyFootprint,
    /// A disc with a value that is not finite, or a radius not above zero.
    #[error(
        "footprint disc {index} is x {x}, y {y}, radius {radius}: all must be finite and the radius above zero"
    )]
    BadDisc {
        /// Index in the list, from zero.
        index: usize,
        /// The value found.
        x: f64,
        /// The value found.
        y: f64,
        /// The value found.
        radius: f64,
    },
    /// A setting is out of range.
    #[error(transparent)]
    Setting(#[from] SettingError),
}
