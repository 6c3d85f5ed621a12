//! `inbye playground`: its page in headless Chromium, used with mouse and keys, and its server with valid and invalid clients.
//! See `support/browser/program.rs` for what happens where there is no Chromium.

mod browser;
mod drives;
mod errors;
pub mod served;
mod server;

use libtest_mimic::Trial;

pub fn trials() -> Vec<Trial> {
    let mut trials = browser::trials();
    trials.extend(drives::trials());
    trials.extend(errors::trials());
    trials.extend(server::trials());
    trials
}
