//! Numbered worlds, each driven with several seeds in a closed loop by a robot that has an empty map: what BARN and
//! `DynaBARN` share.

mod asked;
mod drive;
mod error;
mod key;
mod verdict;

pub use asked::NotAmong;
pub(super) use asked::keep_asked;
pub use drive::{RunFigures, WorldTask, drive, drive_on};
pub use error::WorldError;
pub use key::RunKey;
pub use verdict::Verdict;
