//! Random missions on maps, driven one by one, with a row for each: what the soak, the ablation and the closed loop of
//! sampling densities share.
//!
//! A mission is drawn from its map and one seed: where the robot starts, its goal and yaw, what stands on the way that the
//! map does not show, and who walks there. Same map, same rules, same seed: same mission.

mod built_in;
mod contact;
mod draw;
mod drive;
mod ending;
mod error;
mod people;
mod reach;
mod row;
mod rules;
mod same;
mod shared;
mod site;
mod tally;
mod unmapped;

pub use built_in::built_in_sites;
pub use contact::{Body, Cause, Contact, contact};
pub use draw::Drawn;
pub use drive::{Setup, drive};
pub(super) use ending::verdict;
pub use error::MissionsError;
pub use people::People;
pub use row::{Ending, MissionKey, MissionRow, Touch};
pub use rules::Rules;
pub use same::{Comparison, compare_digests, spread_evenly};
pub(super) use shared::{Which, shared, times_s};
pub use site::MissionSite;
pub use tally::Tally;
pub(super) use tally::mean;
