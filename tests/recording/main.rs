//! Recordings: what ROS 2 tools read from them, and whether they are decided again with the same bits.
//!
//! Other readers are the Python packages `mcap` and `mcap-ros2-support`: see `python.rs`. See `support/adapters.rs` for what
//! happens where there is no adapter.

use std::process::ExitCode;

use libtest_mimic::{Arguments, Trial};

#[cfg(feature = "gpu")]
#[path = "../support/adapters.rs"]
mod adapters;
mod agreement;
mod disks;
mod drives;
#[path = "../support/mcap_copy.rs"]
mod mcap_copy;
mod python;
#[path = "../support/requirements.rs"]
mod requirements;

/// A test by its name.
type Test = (&'static str, fn());

fn main() -> ExitCode {
    let trial = |&(name, test): &Test| {
        Trial::test(name, move || {
            test();
            Ok(())
        })
    };
    let tests = [agreement::TESTS, disks::TESTS];
    let mut trials: Vec<Trial> = tests.into_iter().flatten().map(trial).collect();
    trials.extend(python::trials());
    #[cfg(feature = "gpu")]
    trials.extend(adapters::trials(&agreement::GPU_TESTS));
    libtest_mimic::run(&Arguments::from_args(), trials).exit_code()
}
