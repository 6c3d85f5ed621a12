//! Every engine returns the same bits: for each operation, each sample, the totals and the winner.
//!
//! Runs on each adapter of the machine, and in Chromium, which has another WGSL compiler. `support/adapters.rs`
//! describes what happens without an adapter.

use libtest_mimic::Trial;

use crate::support::{adapters, browser, cpu_trials, gpu_trials};

pub fn trials() -> Vec<Trial> {
    let mut trials = cpu_trials::trials();
    trials.extend(adapters::trials(&gpu_trials::TRIALS));
    trials.extend(browser::trials());
    trials
}
