//! Description of the robot: footprint, limits, tracked drive and encoders.

use thiserror::Error;

use crate::settings::SettingError;

mod footprint;
mod limits;
mod mixer;
mod tracks;

pub use footprint::{Disc, Footprint};
pub use limits::Limits;
pub use mixer::{Mixer, TrackLimits};
pub use tracks::{PerTrack, Side, TrackOdometry, TrackSpeeds, TrackedDrive, travel_m};

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
