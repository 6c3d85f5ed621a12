//! Every engine returns the same bits: operation by operation, sample by sample, in its totals and in its winner.
//!
//! Runs on each adapter present, and in Chromium, whose WGSL compiler is another; see `support/adapters.rs` for what
//! happens where there is none.

use std::process::ExitCode;

use libtest_mimic::Arguments;

#[cfg(feature = "gpu")]
#[path = "support/adapters.rs"]
mod adapters;
#[cfg(feature = "gpu")]
#[path = "support/batch_trials.rs"]
mod batch_trials;
#[cfg(feature = "gpu")]
#[path = "support/browser.rs"]
mod browser;
#[path = "support/cpu_trials.rs"]
mod cpu_trials;
#[cfg(feature = "gpu")]
#[path = "support/extremes.rs"]
mod extremes;
#[cfg(feature = "gpu")]
#[path = "support/gpu_trials.rs"]
mod gpu_trials;
#[cfg(feature = "gpu")]
#[path = "support/kernel.rs"]
mod kernel;
#[cfg(feature = "gpu")]
#[path = "support/loss_trials.rs"]
mod loss_trials;
#[path = "support/operations.rs"]
mod operations;
#[cfg(feature = "gpu")]
#[path = "support/requirements.rs"]
mod requirements;

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    let mut trials = cpu_trials::trials();
    trials.extend(gpu_trials());
    libtest_mimic::run(&arguments, trials).exit_code()
}

#[cfg(feature = "gpu")]
fn gpu_trials() -> Vec<libtest_mimic::Trial> {
    let mut trials = adapters::trials(&gpu_trials::TRIALS);
    trials.extend(browser::trials());
    trials
}

#[cfg(not(feature = "gpu"))]
fn gpu_trials() -> Vec<libtest_mimic::Trial> {
    let ignored = || {
        let reason = "built without the feature `gpu`";
        Ok(libtest_mimic::Completion::ignored_with(reason))
    };
    vec![libtest_mimic::Trial::ignorable_test("gpu", ignored)]
}
