//! What the machine is: its shape, its limits and its tracks. Constants, and how it is told to move by them.

mod encoder;
mod error;
mod footprint;
mod kinematics;
mod limits;
mod mixer;
mod per_track;
mod track_limits;

pub use encoder::{TrackOdometry, tick_difference, travel_m};
pub use error::RobotError;
pub use footprint::{Disc, Footprint};
pub use kinematics::{TrackSpeeds, TrackedDrive};
pub use limits::Limits;
pub use mixer::Mixer;
pub use per_track::{PerTrack, Side};
pub use track_limits::TrackLimits;
