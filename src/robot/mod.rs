//! Description of the robot: footprint, limits, tracked drive and encoders; identification of its response to commands.

use thiserror::Error;

use crate::settings::SettingError;

mod disc_arrangements;
mod disc_cover;
mod footprint;
mod identification;
mod leading_outline;
mod limits;
mod mixer;
mod polygon;
mod tick_time;
mod tracks;

pub use footprint::{Disc, Footprint};
#[cfg(feature = "ros")]
pub(crate) use identification::MAX_RATE;
pub(crate) use identification::is_plausible;
pub use identification::{Interval, MotionEstimate, MotionIdentifier};
pub use limits::Limits;
pub use mixer::{Mixer, TrackLimits};
pub use polygon::Polygon;
pub use tick_time::{LATE_PERIODS, TickClock, TickTime};
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
    /// An invalid polygon of the body.
    #[error("the body's polygon is not valid: {reason}")]
    BadBody {
        /// What is wrong with it.
        reason: &'static str,
    },
    /// A point of the body is outside all discs.
    #[error(
        "the footprint's discs leave ({x:.3}, {y:.3}) of the body uncovered: enlarge them, or leave them out and give the body's corners only"
    )]
    UncoveredBody {
        /// Coordinate of the point, metres.
        x: f64,
        /// Coordinate of the point, metres.
        y: f64,
    },
    /// A setting is out of range.
    #[error(transparent)]
    Setting(#[from] SettingError),
}
