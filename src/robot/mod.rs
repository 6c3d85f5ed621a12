//! What the machine is: its shape, its limits and its tracks. Constants, and how it is told to move by them.

mod error;
mod footprint;
mod kinematics;
mod limits;
mod mixer;
mod sides;
mod ticks;
mod track_limits;

pub use error::RobotError;
pub use footprint::{Disc, Footprint};
pub use kinematics::{TrackSpeeds, TrackedDrive};
pub use limits::Limits;
pub use mixer::Mixer;
pub use sides::{Side, Sides};
pub use ticks::{TrackOdometry, ticks_between, travel_m};
pub use track_limits::TrackLimits;
