//! `inbye playground`: its page in headless Chromium, used with mouse and keys, and its server among clients of all kinds.
//! See `support/browser/program.rs` for what happens where there is no Chromium.

mod browser;
mod devtools;
mod refusals;
mod served;
mod server;

use libtest_mimic::Trial;

pub fn trials() -> Vec<Trial> {
    let mut trials = browser::trials();
    trials.extend(refusals::trials());
    trials.extend(server::trials());
    trials
}
