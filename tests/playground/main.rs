//! `inbye playground`: its page in headless Chromium, used with mouse and keys, and its server among clients of all kinds.
//! See `support/browser/program.rs` for what happens where there is no Chromium.

mod browser;
mod devtools;
#[path = "../support/browser/program.rs"]
mod program;
mod refusals;
#[path = "../support/requirements.rs"]
mod requirements;
mod served;
mod server;

use std::process::ExitCode;

use libtest_mimic::Arguments;

fn main() -> ExitCode {
    let mut trials = browser::trials();
    trials.extend(refusals::trials());
    trials.extend(server::trials());
    libtest_mimic::run(&Arguments::from_args(), trials).exit_code()
}
