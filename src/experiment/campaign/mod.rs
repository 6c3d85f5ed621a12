//! Many runs with a row for each: on all cores, and kept in a file as they finish, so that a campaign that was cut short
//! goes on where it stopped.
//!
//! No file is opened here: a [`Ledger`] is made from what a file held, and says what the file shall hold.

mod crew;
mod error;
mod ledger;
mod settings;

pub use crew::run_cells;
pub use error::CampaignError;
pub(super) use ledger::SETTINGS;
pub use ledger::{Ledger, Row};
pub use settings::settings_digest;
