//! Every engine returns the same bits: operation by operation, sample by sample, in its totals and in its winner.
//!
//! Runs on each adapter present, and in Chromium, whose WGSL compiler is another; see `support/adapters.rs` for what
//! happens where there is none.

use libtest_mimic::Trial;

use crate::support::{adapters, browser, cpu_trials, gpu_trials};

pub fn trials() -> Vec<Trial> {
    let mut trials = cpu_trials::trials();
    trials.extend(adapters::trials(&gpu_trials::TRIALS));
    trials.extend(browser::trials());
    trials
}
