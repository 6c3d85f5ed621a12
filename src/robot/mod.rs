//! What the machine is: its shape, its limits and its tracks. Constants, no state.

mod error;
mod footprint;
mod kinematics;
mod limits;

pub use error::RobotError;
pub use footprint::{Disc, Footprint};
pub use kinematics::{TrackSpeeds, TrackedDrive};
pub use limits::Limits;
